// Long clips in the studio's model: a coarse preview before the first masks, windows shown as they are finished, shots,
// and results of runs that are stopped early.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { exportSource } from '../../build/model/export.js';
import { data } from '../../build/model/exports.js';
import { resizedFrames } from '../../build/model/export-text.js';
import { needsPreview } from '../../build/model/preview.js';
import { showCorrected } from '../../build/model/show-result.js';
import { movingFrames, plainFrame, textureAt } from '../moving.mjs';
import { CLIP, frameGate, maskText, openModel, waitForState } from './studio.mjs';

const WIDTH = 96;
const HEIGHT = 64;

/** Left edge of the square of `twoShots`. */
const leftAt = (t) => 10 + 2 * (t % 40 < 20 ? t % 40 : 40 - (t % 40));

/** A square that moves to and fro; from frame `cut` on another square over another background. */
function twoShots(count, cut) {
  return Array.from({ length: count }, (_, t) => {
    const [left, salt] = [leftAt(t), t < cut ? 1 : 5];
    return plainFrame(WIDTH, HEIGHT, (x, y) => {
      const isInside = x >= left && x < left + 28 && y >= 16 && y < 48;
      const value = isInside ? textureAt(x - left, y, salt + 1) : textureAt(x, y, salt);
      return t < cut ? [value, value, isInside ? 255 - value : value] : [isInside ? 255 : value / 2, value, value / 3];
    });
  });
}

/** Exports data of the result on screen: `coco`, `table` or `tracks`. */
async function exportText(store, id) {
  const source = exportSource(store.state);
  const { stream, read } = resizedFrames(store.state.job, source.masks, WIDTH);
  const edges = { smallest: 0, grow: 0, feather: 0 };
  const subject = { ...source, frames: stream, image: read, edges, objects: (object) => object > 0 };
  const { make } = data.choices.find((choice) => choice.id === id);
  return (await make(subject, { signal: new AbortController().signal, onProgress() {} })).text();
}

test('a clip of one window is one shot, even with a cut', async () => {
  const { app, store } = await openModel(twoShots(20, 10));
  await app.openFiles([CLIP]);
  assert.match(store.state.subline, /^20 frames of 96 × 64 ·/);
  assert.deepEqual([store.state.job.cuts, store.state.job.preview], [[], null]);
});

test('shows windows while later frames are read, and follows objects through each shot', async () => {
  const { app, store } = await openModel(twoShots(130, 90));
  const opening = app.openFiles([CLIP]);
  const { phase, timeline, job, analysis, announcement } = await waitForState(store, (state) => state.isStreaming);
  assert.deepEqual([phase, timeline.numFrames], ['running', 130]);
  assert.ok(job.settledFrames >= 40 && job.settledFrames <= 50, `${job.settledFrames} frames are finished`);
  assert.ok(job.images.length < 120, `${job.images.length} frames were read before any mask was shown`);
  assert.ok(analysis.segmentation.mask(20).some((label) => label > 0));
  assert.match(announcement, /^\d\d of 130 frames are done: 1 moving object$/);

  await opening;
  assert.match(store.state.subline, /^130 frames of 96 × 64 in [34] windows and 2 shots · windows of 50 frames/);
  assert.deepEqual([job.cuts, store.state.timeline.cuts], [[90], [90]]);
  const { segmentation } = store.state.analysis;
  const labelAt = (t) => segmentation.mask(t)[32 * WIDTH + leftAt(t) + 14];
  const labelsIn = (from, to) => [...new Set(Array.from({ length: to - from }, (_, k) => labelAt(from + k)))];
  const [first, second] = [labelsIn(3, 87), labelsIn(93, 127)];
  assert.deepEqual([first.length, second.length], [1, 1], `squares have the labels ${first} and ${second}`);
  assert.ok(first[0] > 0 && second[0] > 0 && first[0] !== second[0]);

  // Objects of different windows are joined in all of them.
  const { corrections } = job;
  assert.equal(corrections.splitsAtPlace, true);
  showCorrected(store, await corrections.join(first[0], second));
  const coco = JSON.parse(await exportText(store, 'coco'));
  assert.equal(coco.images.length, 130);
  assert.ok(coco.annotations.length > 100 && coco.annotations.every(({ track_id: id }) => id !== second[0]));
  assert.match(await exportText(store, 'tracks'), /^130\n\d+\n/);
});

test('a run stopped early keeps its windows, and continues to the same result', async () => {
  const gate = frameGate();
  const { app, store } = await openModel(movingFrames(110, [64, 48]), { gate });
  await app.openFiles([CLIP]);
  const masks = maskText(store.state);
  // Enough frames for the first window, but not for the second.
  gate.count = 70;
  const running = app.rerun();
  await waitForState(store, ({ job, phase }) => phase === 'running' && job.settledFrames > 0);
  app.cancel();
  await waitForState(store, ({ phase }) => phase === 'done');
  const { job, timeline, notice, subline } = store.state;
  const { numFrames } = timeline;
  assert.ok(numFrames >= 40 && numFrames <= 50, `${numFrames} frames`);
  assert.equal(notice, `Stopped early: ${numFrames} of 110 frames are ready to save. Continue to finish.`);
  assert.match(subline, new RegExp(`^${numFrames} frames of 64 × 48 in [12] windows?`));
  assert.equal(maskText(store.state), masks.split('|').slice(0, numFrames).join('|'));
  assert.deepEqual([job.isPartial, job.corrector, job.pacePerPixel], [true, null, null]);
  assert.equal(JSON.parse(await exportText(store, 'coco')).images.length, numFrames);
  assert.match(await exportText(store, 'tracks'), new RegExp(`^${numFrames}\n[1-9]`));
  assert.match(await exportText(store, 'table'), /\n\d+,/);

  const resuming = app.resume();
  assert.deepEqual([store.state.phase, store.state.timeline.numFrames], ['running', 110]);
  gate.open();
  await Promise.all([running, resuming]);
  assert.equal(maskText(store.state), masks);
  assert.equal(store.state.job, job, 'the same run goes on');
  assert.deepEqual([store.state.notice, job.isPartial, job.corrector], ['', false, job.corrections]);
});

const PREVIEW_SIZE = { width: 320, height: 216 };
const SQUARE = { top: 50, side: 80 };

/** A square that moves two pixels a frame, large enough for a preview. */
function largeFrames(count) {
  const { top, side } = SQUARE;
  return Array.from({ length: count }, (_, t) =>
    plainFrame(PREVIEW_SIZE.width, PREVIEW_SIZE.height, (x, y) => {
      const left = 20 + 2 * t;
      const isInside = x >= left && x < left + side && y >= top && y < top + side;
      const value = isInside ? textureAt((x - left) >> 1, y >> 1, 2) : textureAt(x >> 1, y >> 1, 1);
      return [value, value, isInside ? 255 - value : value];
    }),
  );
}

/** Opens a clip with a preview, whose frames are held back from number `count` on. */
async function openLarge(count) {
  const gate = frameGate(count);
  const model = await openModel(largeFrames(50), { gate });
  return { ...model, gate, opening: model.app.openFiles([CLIP]) };
}

test('shows a coarse preview of the first frames until there are masks', async () => {
  const { store, gate, opening } = await openLarge(20);
  const { phase, timeline, announcement, job, analysis } = await waitForState(store, ({ preview }) => preview);
  assert.deepEqual([phase, timeline.numFrames, analysis], ['running', 15, null]);
  assert.equal(announcement, 'Coarse preview of the first frames.');
  for (let t = 0; t < 15; t += 1) {
    const masked = t - (t % 2);
    assert.equal(job.preview.maskedFrame(t), masked, 'picture and mask show the same frame');
    let [both, either] = [0, 0];
    job.preview.labels(t).forEach((label, p) => {
      const [x, y] = [(p % PREVIEW_SIZE.width) - 20 - 2 * masked, Math.floor(p / PREVIEW_SIZE.width) - SQUARE.top];
      const isInside = x >= 0 && x < SQUARE.side && y >= 0 && y < SQUARE.side;
      both += Number(isInside && label === 1);
      either += Number(isInside || label > 0);
    });
    assert.ok(both / either > 0.7, `frame ${t}: ${both / either}`);
  }
  gate.open();
  await waitForState(store, ({ preview }) => !preview);
  assert.notEqual(store.state.analysis, null, 'masks replace the preview');
  await opening;
  assert.deepEqual([store.state.phase, store.state.preview], ['done', null]);
});

test('a preview stays after a cancel and gives way to another clip', async () => {
  const { app, store, gate, opening } = await openLarge(20);
  await waitForState(store, ({ preview }) => preview);
  app.cancel();
  assert.equal(store.state.phase, 'stopped');
  assert.notEqual(store.state.preview, null);
  await opening;
  const sample = app.openSample();
  assert.equal(store.state.preview, null);
  gate.open();
  await waitForState(store, ({ phase }) => phase === 'running');
  app.cancel();
  await sample;
});

test('a run goes on without a preview that fails', async () => {
  const { app, store, gate, opening } = await openLarge(5);
  const { job } = await waitForState(store, (state) => state.job?.images.length === 5);
  const closed = new Promise((resolve) => job.preview.abort.signal.addEventListener('abort', resolve));
  job.preview.frames.error(new Error('no frames'));
  await closed;
  gate.open();
  await waitForState(store, () => job.images.length === 50 && job.stages[1].done > 0);
  assert.deepEqual([store.state.phase, job.preview.masks], ['running', null]);
  app.cancel();
  await opening;
});

test('only clips whose masks take long have a preview', () => {
  const clip = { kind: 'video', width: 1920, height: 1080 };
  const trim = { start: 0, frames: 50, step: 1, side: 480 };
  assert.equal(needsPreview(clip, trim), true);
  assert.equal(needsPreview(clip, { ...trim, frames: 15 }), false);
  assert.equal(needsPreview({ ...clip, width: 200, height: 100 }, { ...trim, frames: 500 }), false);
});
