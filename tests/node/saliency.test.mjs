// What a run finds in a scene that is known: clusters, masks, saliency, foreground and components.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { createSession, parameters, synthClip } from 'tracecut';
import { SMALL, framesOf, open, ready, rejects, segment } from './support.mjs';

/** Large enough for components: the walker, the van and the balloon. */
const SCENE = { width: 256, height: 144, frames: 12, seed: 2 };
const clip = await synthClip(SCENE);
const session = await createSession();
for (let t = 0; t < SCENE.frames; t += 1) await session.push(clip.frame(t));
const result = await session.run();
const masks = Array.from({ length: SCENE.frames }, (_, t) => clip.mask(t));
after(() => session.close());

test('most trajectories of the scene carry the label of the object that they are on', () => {
  const { count, startFrame, offset, x, y } = result.trajectories;
  const votes = Array.from({ length: result.clusters.count }, () => new Map());
  for (let i = 0; i < count; i += 1) {
    const object = masks[startFrame[i]][Math.round(y[offset[i]]) * SCENE.width + Math.round(x[offset[i]])];
    const vote = votes[result.clusters.label[i]];
    vote.set(object, (vote.get(object) ?? 0) + 1);
  }
  const right = votes.reduce((sum, vote) => sum + Math.max(...vote.values()), 0);
  const objects = new Set(votes.map((vote) => [...vote].sort((a, b) => b[1] - a[1])[0][0]));
  assert.ok(right / count > 0.97, `${((100 * right) / count).toFixed(1)} % of ${count} trajectories`);
  assert.ok(objects.size === 4, `objects found: ${[...objects]}`);
});

test('masks cover the objects of the scene', () => {
  const both = Array.from({ length: clip.numObjects + 1 }, () => new Array(result.objects.length + 1).fill(0));
  for (let t = 0; t < SCENE.frames; t += 1) {
    const [truth, mask] = [masks[t], result.labels(t)];
    for (let p = 0; p < truth.length; p += 1) both[truth[p]][mask[p]] += 1;
  }
  const sum = (list) => list.reduce((a, b) => a + b, 0);
  const overlap = both.map((row, object) => {
    const unions = row.map((intersection, label) => sum(row) + sum(both.map((counts) => counts[label])) - intersection);
    return Math.max(
      ...row.map((intersection, label) => ((label === 0) === (object === 0) ? intersection / unions[label] : 0)),
    );
  });
  assert.ok(Math.min(...overlap) > 0.7, `intersection over union: ${overlap.map((v) => v.toFixed(3))}`);
});

test('saliency has an entry for each trajectory, and the foreground is above the threshold', async () => {
  const { trajectories, saliency } = await segment(await framesOf());
  const { ofPoints, inContext, foreground } = saliency;
  assert.deepEqual([ofPoints.length, inContext.length, foreground.length], new Array(3).fill(trajectories.count));
  assert.ok([ofPoints, inContext].every((table) => table.every((s) => s >= 0 && s <= 1)));
  const threshold = parameters().find(({ name }) => name === 'saliency.threshold').default;
  foreground.forEach((f, i) => assert.equal(f, Number(inContext[i] > threshold), `trajectory ${i} of ${inContext[i]}`));
});

test('what moves in the scene is salient and foreground, what the camera pans over is not', async () => {
  const { trajectories, saliency } = result;
  const { count, startFrame, offset, x, y } = trajectories;
  // Where a trajectory is in the middle of its life tells whose it is.
  const objects = Array.from({ length: count }, (_, i) => {
    const p = Math.floor((offset[i] + offset[i + 1]) / 2);
    return masks[startFrame[i] + p - offset[i]][Math.round(y[p]) * SCENE.width + Math.round(x[p])];
  });
  for (let object = 0; object <= clip.numObjects; object += 1) {
    const members = [...objects.keys()].filter((i) => objects[i] === object);
    const mean = (table) => members.reduce((sum, i) => sum + table[i], 0) / members.length;
    const facts = `object ${object}: ${members.length}, s ${mean(saliency.ofPoints)}, in context ${mean(saliency.inContext)}, foreground ${mean(saliency.foreground)}`;
    assert.ok(members.length >= 10, facts);
    if (object === 0) assert.ok(mean(saliency.foreground) < 0.05 && mean(saliency.inContext) < 0.45, facts);
    else assert.ok(mean(saliency.foreground) > 0.9 && mean(saliency.inContext) > 0.7, facts);
  }
  const { saliency: map, width } = await result.saliencyMap(8);
  const sums = [0, 0, 0, 0];
  masks[8].forEach((object, p) => {
    sums[object > 0 ? 0 : 1] += map[Math.floor(p / SCENE.width) * width + (p % SCENE.width)];
    sums[object > 0 ? 2 : 3] += 1;
  });
  assert.ok(
    sums[0] / sums[2] > 0.8 && sums[1] / sums[3] < 0.5,
    `objects ${sums[0] / sums[2]}, background ${sums[1] / sums[3]}`,
  );
});

test('a clip in which nothing moves has no foreground and no components', async () => {
  const [frame] = await framesOf();
  const { saliency, components } = await segment(new Array(SMALL.frames).fill(frame));
  assert.ok(saliency.foreground.every((f) => f === 0));
  assert.ok(components.count.every((n) => n === 0) && components.ofPoint.every((c) => c === -1));
});

test('components lie in the foreground, numbered in each frame', () => {
  const { trajectories, saliency, components } = result;
  const { count, startFrame, offset, x } = trajectories;
  assert.deepEqual([components.count.length, components.ofPoint.length], [SCENE.frames, x.length]);
  assert.ok(
    components.count.every((n) => n >= 2),
    `components: ${components.count}`,
  );
  const componentObjects = Array.from(components.count, () => new Set());
  for (let i = 0; i < count; i += 1) {
    for (let p = offset[i]; p < offset[i + 1]; p += 1) {
      const component = components.ofPoint[p];
      if (component < 0) {
        assert.equal(component, -1);
        continue;
      }
      assert.equal(saliency.foreground[i], 1, `component ${component} of a background trajectory`);
      componentObjects[startFrame[i] + p - offset[i]].add(component);
    }
  }
  componentObjects.forEach((numbers, t) =>
    assert.deepEqual(
      [...numbers].sort((a, b) => a - b),
      Array.from({ length: components.count[t] }, (_, k) => k),
    ),
  );
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
  const tracks = {
    startFrame: [0, 0, 0],
    offset: [0, 3, 6, 9],
    x: [9, 9, 9, 30, 31, 32, 50, 50, 50],
    y: [9, 9, 9, 20, 20, 20, 40, 40, 40],
  };
  await session.setTrajectories({ numFrames: 3, width: 64, height: 48, ...tracks });
  const result = await session.run();
  assert.deepEqual([result.saliency.ofPoints.length, result.components.count.length], [0, 0]);
  await rejects(result.saliencyMap(0), 'state', /no saliency maps/);
});

test('choices are options by name; others are refused with the names that there are', async (t) => {
  const mode = parameters().find(({ name }) => name === 'connectedness.mode');
  assert.equal(mode.kind, 'choice');
  assert.ok(mode.choices.includes(mode.default));
  for (const choice of mode.choices) await open(t, { connectedness: { mode: choice } });
  const legal = new RegExp(`connectedness\\.mode = .* \\(expected one of ${mode.choices.join(', ')}\\)`);
  for (const wrong of ['sometimes', 'Paper', '', 1, true])
    await rejects(open(t, { connectedness: { mode: wrong } }), 'param', legal);
  const message = /connectedness\.mode = a list of 1 \(expected .* or a name\)/;
  await rejects(open(t, { connectedness: { mode: ['paper'] } }), 'param', message);
});
