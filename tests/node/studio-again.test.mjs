// Running again in the studio keeps what was corrected and chosen, as far as it applies, and is one step of undo.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { showCorrected } from '../../build/model/show-result.js';
import { movingFrames } from '../moving.mjs';
import { CLIP, openModel } from './studio.mjs';

/** A clip that has been segmented, and what a user would do with it. */
async function opened(frames = movingFrames(16, [96, 64])) {
  const { app, store } = await openModel(frames);
  await app.openFiles([CLIP]);
  assert.equal(store.state.phase, 'done');
  const points = () => store.state.analysis.segmentation;
  return {
    app,
    store,
    masks: () => Array.from({ length: points().result.numFrames }, (_, t) => points().mask(t).join('')).join('|'),
    /** The pixels and the middle of each label of a frame. */
    objects: (t) => middles(points().mask(t), points().result.width),
    /** Paints a line from and to parts of the picture; a label of 0 wipes away. */
    async paint({ t, from, to, label, carries = true }) {
      const { width, height } = points().result;
      const at = ([x, y]) => [x * width, y * height];
      const { corrections } = store.state.job;
      const stroke = { t, points: [...at(from), ...at(to)], radius: 0.06 * width };
      const painted = await corrections.paint({ label: label ?? corrections.newLabel(), stroke });
      if (carries) await corrections.carry(painted, new AbortController().signal, () => {});
      showCorrected(store);
    },
  };
}

function middles(mask, width) {
  const all = {};
  mask.forEach((label, p) => {
    const one = (all[label] ??= { n: 0, x: 0, y: 0 });
    one.n += 1;
    one.x += p % width;
    one.y += Math.floor(p / width);
  });
  for (const one of Object.values(all)) Object.assign(one, { x: one.x / one.n, y: one.y / one.n });
  return all;
}

const disc = { t: 4, from: [0.75, 0.2], to: [0.83, 0.24] };

test('of another part of the clip goes on with what still applies, and lists the rest', async () => {
  const { app, store, masks, objects, paint } = await opened();
  await paint(disc);
  await paint({ t: 1, from: [0.2, 0.5], to: [0.3, 0.5], label: 0, carries: false });
  const [before, was] = [masks(), objects(4)];
  store.set({ trim: { ...store.state.trim, start: 3, frames: 13 } });
  await app.rerun();
  assert.equal(store.state.timeline.numFrames, 13);
  // The frame at hand was the fifth of the clip.
  const now = objects(1);
  assert.deepEqual(Object.keys(now), ['0', '1', '2']);
  assert.deepEqual(now[2], was[2]);
  assert.ok(Math.abs(now[1].x - was[1].x) < 2 && Math.abs(now[1].y - was[1].y) < 2);
  assert.equal(store.state.notice, 'These corrections no longer apply (undo restores them): erasing in frame 2.');
  await app.restore();
  assert.equal(masks(), before);
  assert.equal(store.state.notice, '');
});

test('at another size has the same places', async () => {
  const { app, store, objects, paint } = await opened(movingFrames(8, [400, 260]));
  await paint({ t: 4, from: [0.5, 0.7], to: [0.8, 0.7] });
  const was = objects(4);
  store.set({ trim: { ...store.state.trim, side: 320 } });
  await app.rerun();
  const now = objects(4);
  const [painted, label] = [now, was].map((all) => all[Math.max(...Object.keys(all))]);
  assert.ok(Math.abs(painted.n / (0.64 * label.n) - 1) < 0.05, `${painted.n} of ${label.n} pixels`);
  for (const axis of ['x', 'y']) assert.ok(Math.abs(painted[axis] - 0.8 * label[axis]) < 1);
  assert.doesNotMatch(store.state.notice, /no longer/);
});

test('of a clip that takes several windows', async () => {
  const { app, store, masks, paint } = await opened(movingFrames(110, [96, 64]));
  await paint({ ...disc, carries: false });
  await store.state.job.corrections.join(0, [1]);
  showCorrected(store);
  const before = masks();
  await app.rerun();
  assert.equal(masks(), before);
  await app.restore();
  assert.equal(masks(), before);
});

test('that is begun anew or cancelled on the way still keeps it', async () => {
  const { app, store, masks, paint } = await opened();
  await paint(disc);
  const before = masks();
  const running = app.rerun();
  await new Promise((resolve) => setTimeout(resolve, 50));
  app.cancel();
  await running;
  assert.equal(store.state.phase, 'stopped');
  await app.rerun();
  assert.equal(store.state.phase, 'done');
  assert.equal(masks(), before);
});

test('with other settings is undone, also where nothing was corrected: masks and settings are as before', async () => {
  const { app, store, masks } = await opened(movingFrames(8, [96, 64]));
  const first = store.state.job;
  const [before, { trim }] = [masks(), store.state];
  store.set({ changed: new Map([['trajectory.gridStep', 12]]), trim: { ...trim, frames: 6 } });
  await app.rerun();
  assert.equal(store.state.timeline.numFrames, 6);
  assert.equal(store.state.previousJob, first);
  // One result is kept, that of the last run that ended.
  const second = store.state.job;
  store.set({ changed: new Map([['trajectory.gridStep', 10]]) });
  const running = app.rerun();
  app.cancel();
  await running;
  assert.equal(store.state.previousJob, second);
  await app.restore();
  assert.deepEqual([store.state.job, store.state.previousJob], [second, null]);
  assert.deepEqual([...store.state.changed], [['trajectory.gridStep', 12]]);
  assert.deepEqual(store.state.trim, { ...trim, frames: 6 });
  store.set({ changed: new Map(), trim });
  await app.rerun();
  assert.equal(masks(), before);
  store.set({ changed: new Map([['trajectory.gridStep', 12]]) });
  await app.rerun();
  await app.restore();
  assert.equal(masks(), before);
  assert.deepEqual([store.state.changed.size, store.state.phase], [0, 'done']);
});

test('is asked about where there are corrections, and is undone step by step before that', async () => {
  const { app, store, masks, paint } = await opened();
  await paint(disc);
  store.set({ hidden: new Set([1]) });
  const before = masks();
  app.confirmRerun = async () => false;
  const { job } = store.state;
  await app.rerun();
  assert.equal(store.state.job, job);
  app.confirmRerun = async () => true;
  await app.rerun();
  assert.equal(masks(), before);
  assert.deepEqual([...store.state.hidden], [1]);
  const { corrections } = store.state.job;
  assert.equal(corrections.undoCount(), 0, 'what was taken over is one step with the run');
  await paint({ t: 4, from: [0.3, 0.5], to: [0.3, 0.7], label: 0 });
  assert.notEqual(masks(), before);
  showCorrected(store, await corrections.undo());
  assert.equal(masks(), before);
  assert.equal(store.state.previousJob, job);
});

test('has the same corrections, also those of the session, and each can be undone', async () => {
  const { app, store } = await openModel();
  await app.openFiles([CLIP]);
  const masks = () =>
    Array.from({ length: 16 }, (_, t) => store.state.analysis.segmentation.mask(t).join('')).join('|');
  const before = masks();
  const change = async (act) => showCorrected(store, await act(store.state.job.corrections));
  const strokeOn = (object) => {
    const { width } = store.state.analysis.segmentation.result;
    const mask = store.state.analysis.segmentation.mask(8);
    const all = [...mask.keys()].filter((p) => mask[p] === object);
    const p = all[all.length >> 1];
    return { t: 8, points: [p % width, Math.floor(p / width), (p % width) + 2, Math.floor(p / width)], radius: 2 };
  };
  await change((corrections) => corrections.join(1, [2]));
  await change((corrections) => corrections.split(1));
  await change((corrections) => corrections.joinStrokes([strokeOn(1), strokeOn(3)]));
  await change((corrections) => corrections.join(0, [2]));
  const corrected = masks();
  assert.notEqual(corrected, before);
  await app.rerun();
  assert.equal(masks(), corrected);
  assert.equal(store.state.notice, '');
  await app.restore();
  for (let step = 0; step < 4; step += 1) await change((corrections) => corrections.undo());
  assert.equal(masks(), before);
});
