// previewMasks: coarse masks of a clip's first frames.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { previewMasks, segmentVideo, synthClip, VideoResult } from 'tracecut';
import { framesOf, plain, rejects } from './support.mjs';

const MOVING = { width: 384, height: 216, frames: 16, seed: 0 };

const masksOf = (result) => Array.from({ length: result.numFrames }, (_, t) => result.labels(t));

/** Intersection over union of what is not background. */
function overlap(a, b) {
  let [both, either] = [0, 0];
  for (let k = 0; k < a.length; k += 1) {
    both += Number(a[k] > 0 && b[k] > 0);
    either += Number(a[k] > 0 || b[k] > 0);
  }
  return both / either;
}

test('eight frames, every second one, at the size of the frames, much like the true ones', async () => {
  const clip = await synthClip(MOVING);
  let asked = 0;
  async function* counted() {
    for (let t = 0; t < MOVING.frames; t += 1) {
      asked += 1;
      yield clip.frame(t);
    }
  }
  const coarse = await previewMasks(counted(), { frameRate: 10 });
  assert.ok(coarse instanceof VideoResult);
  assert.deepEqual(
    [...coarse.times],
    [0, 2, 4, 6, 8, 10, 12, 14].map((t) => t / 10),
  );
  assert.deepEqual([coarse.width, coarse.height], [MOVING.width, MOVING.height]);
  assert.equal(asked, 15, 'no frame is read that is not needed');
  masksOf(coarse).forEach((mask, k) => {
    const same = overlap(mask, clip.mask(2 * k));
    assert.ok(same > 0.6, `frame ${2 * k}: ${same}`);
  });
});

test('is segmentVideo of these frames at this size, and options say which', async () => {
  const frames = (await framesOf(MOVING)).slice(0, 12);
  const options = { step: 3, maxFrames: 3, clip: { maxSide: 160, seed: 4 } };
  const coarse = await previewMasks(frames, options);
  const expected = await segmentVideo(frames, options).collect();
  assert.deepEqual(coarse.times, expected.times);
  assert.deepEqual(masksOf(coarse), masksOf(expected));
  const usual = { step: 2, maxFrames: 8, clip: { maxSide: 320 } };
  assert.deepEqual(
    masksOf(await previewMasks(frames, { step: undefined, clip: undefined })),
    masksOf(await segmentVideo(frames, usual).collect()),
  );
});

test('bad options and sources reject as segmentVideo says, and an abort ends it', async () => {
  const frames = await framesOf({ width: 64, height: 48, frames: 16, seed: 3 });
  await rejects(previewMasks(frames, { clip: 320 }), 'param', /clip = 320 .*maxSide/);
  await rejects(previewMasks(frames, { clip: { maxSide: 2 } }), 'param', /clip\.maxSide = 2 .*16/);
  await rejects(previewMasks(frames, { steps: 2 }), 'param', /steps/);
  await rejects(previewMasks(frames, 7), 'param', /options = 7/);
  const still = await previewMasks([plain(16, 16)]);
  assert.deepEqual([still.numFrames, still.objects], [1, []]);
  const stop = new AbortController();
  const ends = previewMasks(frames, { signal: stop.signal });
  stop.abort(new Error('enough'));
  await assert.rejects(ends, /enough/);
});
