// A session on a thread of its own in Node: the calling one hands over frames and results and does nothing else.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { monitorEventLoopDelay } from 'node:perf_hooks';
import { test } from 'node:test';
import { segmentVideo } from 'tracecut';
import { superpixels, trajectories } from 'tracecut/stages';
import { enlargeMask } from 'tracecut/edit';
import { root } from '../../scripts/tools.mjs';
import { SMALL, fingerprint, framesOf, open, rejects, segment, trappingWasm, watchMemories } from './support.mjs';

test('no instance is in the calling thread, and results are the same', async (t) => {
  const frames = await framesOf();
  const expected = fingerprint(await segment(frames));
  const memories = watchMemories(t);
  const gaps = monitorEventLoopDelay({ resolution: 5 });
  gaps.enable();
  const session = await open(t, { worker: true });
  for (const frame of frames) await session.push(frame);
  const stages = new Set();
  const result = await session.run({ onProgress: ({ stage }) => stages.add(stage) });
  gaps.disable();
  t.diagnostic(`longest gap of the event loop: ${(gaps.max / 1e6).toFixed(1)} ms`);
  assert.equal(fingerprint(result), expected);
  assert.ok(stages.has('masks'));
  assert.equal((await result.superpixels(2)).width, SMALL.width);
  assert.equal(
    (await session.merge(0, 1)).objects.some(({ label }) => label === 1),
    false,
  );
  assert.equal(memories.length, 0);
});

test('videos, trajectories, single pictures and larger masks too', async (t) => {
  const frames = await framesOf();
  const video = await segmentVideo(frames).collect();
  const plain = await superpixels(frames[0]);
  const labels = video.labels(0);
  const small = {
    labels: labels.filter((_, p) => p % 2 === 0 && Math.floor(p / 128) % 2 === 0),
    width: 64,
    height: 36,
  };
  const large = await enlargeMask(small, frames[0]);
  const memories = watchMemories(t);
  assert.deepEqual((await segmentVideo(frames, { worker: true, threads: 2 }).collect()).labels(4), video.labels(4));
  assert.deepEqual((await superpixels(frames[0], { worker: true })).label, plain.label);
  assert.ok((await trajectories(frames, { worker: true })).count > 50);
  assert.deepEqual(await enlargeMask(small, frames[0], { worker: true }), large);
  assert.equal(memories.length, 0);
  await superpixels(frames[0]);
  assert.equal(memories.length, 1, 'an instance in this thread is seen');
});

test('errors come through: options, a trap, a session that is closed', async (t) => {
  await rejects(open(t, { worker: true, flow: { patchStride: -1 } }), 'param', /flow\.patchStride = -1/);
  const session = await open(t, { worker: true, wasm: await trappingWasm() });
  for (const frame of await framesOf()) await session.push(frame);
  await rejects(session.run(), 'poisoned');
  const other = await open(t, { worker: true });
  for (const frame of await framesOf()) await other.push(frame);
  const running = other.run();
  other.close();
  await rejects(running, 'closed');
});

test('a session that nobody closed keeps no process alive, and one at work does', () => {
  const script = `
    import { createSession, synthClip } from 'tracecut';
    const clip = await synthClip(${JSON.stringify(SMALL)});
    const session = await createSession({ worker: true });
    for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
    session.run().then(({ objects }) => console.log(objects.length > 0));`;
  const said = execFileSync(process.execPath, ['--input-type=module', '--eval', script], {
    cwd: root,
    encoding: 'utf8',
  });
  assert.equal(said, 'true\n');
});
