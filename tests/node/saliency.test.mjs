// Saliency, foreground and components of a run.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parameters } from 'tracecut';
import { SMALL, framesOf, open, ready, rejects, segment } from './support.mjs';

test('saliency has an entry for each trajectory, and the foreground is what is above the threshold', async () => {
  const { trajectories, saliency } = await segment(await framesOf());
  const { ofPoints, inContext, foreground } = saliency;
  assert.deepEqual([ofPoints.length, inContext.length, foreground.length], new Array(3).fill(trajectories.count));
  assert.ok([ofPoints, inContext].every((table) => table.every((s) => s >= 0 && s <= 1)));
  const threshold = parameters().find(({ name }) => name === 'saliency.threshold').default;
  foreground.forEach((f, i) => assert.equal(f, Number(inContext[i] > threshold), `trajectory ${i} of ${inContext[i]}`));
});

test('components lie in the foreground, numbered in each frame', async () => {
  const { trajectories, saliency, components } = await segment(await framesOf());
  const { count, startFrame, offset, x } = trajectories;
  assert.deepEqual([components.count.length, components.ofPoint.length], [SMALL.frames, x.length]);
  const seen = Array.from(components.count, () => new Set());
  for (let i = 0; i < count; i += 1) {
    for (let p = offset[i]; p < offset[i + 1]; p += 1) {
      const component = components.ofPoint[p];
      if (component < 0) {
        assert.equal(component, -1);
        continue;
      }
      assert.equal(saliency.foreground[i], 1, `component ${component} of a background trajectory`);
      seen[startFrame[i] + p - offset[i]].add(component);
    }
  }
  seen.forEach((numbers, t) => assert.deepEqual([...numbers].sort((a, b) => a - b), Array.from({ length: components.count[t] }, (_, k) => k)));
});

test('saliency maps have a value for each pixel, for the last frame too', async (t) => {
  const session = await ready(t, { clip: { maxSide: 64 } });
  await rejects(session.saliencyMap(0), 'state', /saliency map of frame 0/);
  const result = await session.run();
  for (const frame of [0, SMALL.frames - 1]) {
    const map = await result.saliencyMap(frame);
    assert.deepEqual([map.width, map.height, map.scaleX, map.scaleY], [64, 36, 2, 2]);
    assert.equal(map.saliency.length, 64 * 36);
    assert.ok(map.saliency.every((s) => s >= 0 && s <= 1));
    assert.deepEqual(await session.saliencyMap(frame), map);
  }
  await rejects(result.saliencyMap(SMALL.frames), 'param', /t = 8/);
  session.close();
  await rejects(result.saliencyMap(0), 'closed', /saliency maps of a result come from its session/);
});

test('trajectories from outside have no saliency and no components', async (t) => {
  const session = await open(t);
  const tracks = { startFrame: [0, 0, 0], offset: [0, 3, 6, 9], x: [9, 9, 9, 30, 31, 32, 50, 50, 50], y: [9, 9, 9, 20, 20, 20, 40, 40, 40] };
  await session.setTrajectories({ numFrames: 3, width: 64, height: 48, ...tracks });
  const result = await session.run();
  assert.deepEqual([result.saliency, result.components], [null, null]);
  await rejects(result.saliencyMap(0), 'state', /no saliency maps/);
});

test('choices are options by name; others are refused with the names that there are', async (t) => {
  const mode = parameters().find(({ name }) => name === 'connectedness.mode');
  assert.equal(mode.kind, 'choice');
  assert.ok(mode.choices.includes(mode.default));
  for (const choice of mode.choices) await open(t, { connectedness: { mode: choice } });
  const legal = new RegExp(`connectedness\\.mode = .* \\(expected one of ${mode.choices.join(', ')}\\)`);
  for (const wrong of ['sometimes', 'Paper', '', 1, true]) await rejects(open(t, { connectedness: { mode: wrong } }), 'param', legal);
  await rejects(open(t, { connectedness: { mode: ['paper'] } }), 'param', /connectedness\.mode = a list of 1 \(expected .* or a name\)/);
});
