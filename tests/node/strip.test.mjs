// videoStrip over lists: which frames are taken, at what size, and what is refused.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { segmentVideo, videoFrames, videoStrip } from 'tracecut';
import { framesOf, plain, png, rejects } from './support.mjs';

/** A list of frames whose red says their number. */
const numbered = (count) => Array.from({ length: count }, (_, k) => plain(64, 32, k));

/** One property of each of a list. */
const each = (list, name) => list.map((one) => one[name]);

async function stripOf(source, options) {
  const seen = [];
  for await (const { frame, index, time, duration } of videoStrip(source, options))
    seen.push({ number: frame.data[0], index, time, duration, size: `${frame.width}x${frame.height}` });
  return seen;
}

test('frames are the middles of equal parts, in order, with their times', async () => {
  const strip = await stripOf(numbered(40), { count: 4, frameRate: 10 });
  assert.deepEqual(each(strip, 'number'), [5, 15, 25, 35]);
  assert.deepEqual(strip[1], { number: 15, index: 1, time: 1.5, duration: 0.1, size: '64x32' });
});

test('a part of the clip, at a smaller size; a short clip gives each frame once', async () => {
  const part = await stripOf(numbered(40), { count: 2, frameRate: 10, start: 1, end: 2, size: 16 });
  assert.deepEqual(
    part.map(({ number, size }) => [number, size]),
    [
      [12, '16x8'],
      [17, '16x8'],
    ],
  );
  const few = await stripOf(numbered(3), {});
  assert.deepEqual(each(few, 'number'), [0, 1, 2]);
});

test('leaving early and aborting end it', async () => {
  for await (const { index } of videoStrip(numbered(40))) if (index === 1) break;
  const controller = new AbortController();
  controller.abort(new Error('enough'));
  await assert.rejects(stripOf(numbered(40), { signal: controller.signal }), /enough/);
});

test('what has no strip, and what is no option, is refused by name', async () => {
  async function* generated() {
    yield* await framesOf({ width: 32, height: 32, frames: 3 });
  }
  await rejects(stripOf(generated()), 'unsupported', /no strip/);
  await rejects(stripOf(numbered(3), { count: 0 }), 'param', /count = 0 .*1/);
  await rejects(stripOf(numbered(3), { step: 2 }), 'param', /step = 2/);
  await rejects(stripOf(numbered(3), { many: 2 }), 'param', /many = 2/);
  await rejects(stripOf(numbered(3), { start: 9 }), 'no-frames', /no frame from 9 s/);
});

test('with onDamage frames before a damaged picture come, in a strip, decoded and segmented; without it that is an error', async () => {
  const files = (await framesOf({ width: 48, height: 32, frames: 6 })).map((frame) => png(frame));
  files[4] = files[4].subarray(0, 70);
  const told = [];
  const onDamage = ({ frames, total, error }) => told.push([frames, total, error.code]);
  let count = 0;
  for await (const { index } of videoFrames(files, { onDamage })) count = index + 1;
  assert.equal(count, 4);
  const { numFrames } = await segmentVideo(files, { window: 3, overlap: 1, onDamage }).collect();
  assert.equal(numFrames, 4);
  assert.equal((await stripOf(files, { onDamage })).length, 4);
  assert.deepEqual(told, Array(3).fill([4, 6, 'decode']));
  await rejects(stripOf(files), 'decode');
  await rejects(segmentVideo(files).collect(), 'decode');
  // One frame is no clip.
  await rejects(segmentVideo([files[0], files[4]], { onDamage }).collect(), 'decode');
  await rejects(stripOf(files, { onDamage: true }), 'param', /onDamage = true/);
});
