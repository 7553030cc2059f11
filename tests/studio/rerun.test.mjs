// Another run in the studio: corrections and hidden objects are carried over as far as they still apply, and undo restores
// the result before.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { showCorrected } from '../../build/model/show-result.js';
import { movingFrames } from '../moving.mjs';
import { CLIP, masksOf, openModel, regionsOf, show, strokeOn, waitForState } from './studio.mjs';

/** Opens a clip and segments it. */
async function openRun(frames = movingFrames(16, [96, 64])) {
  const { app, store } = await openModel(frames);
  await app.openFiles([CLIP]);
  assert.equal(store.state.phase, 'done');
  return { app, store };
}

/** Paints a line between places, as shares of the picture; a label of 0 erases. */
async function paint(store, { t, from, to, label, isCarried = true }) {
  const { corrections } = store.state.job;
  const { width, height } = store.state.analysis.segmentation.result;
  const points = [from, to].flatMap(([x, y]) => [x * width, y * height]);
  const stroke = { t, points, radius: 0.06 * width };
  const edit = await corrections.paint({ label: label ?? corrections.newLabel(), stroke });
  if (isCarried) await corrections.carry(edit, new AbortController().signal, () => {});
  showCorrected(store);
}

const NEW_OBJECT = { t: 4, from: [0.75, 0.2], to: [0.83, 0.24] };

test('a run of another part keeps what still applies, and lists the rest', async () => {
  const { app, store } = await openRun();
  await paint(store, NEW_OBJECT);
  await paint(store, { t: 1, from: [0.2, 0.5], to: [0.3, 0.5], label: 0, isCarried: false });
  const [before, objects] = [masksOf(store), regionsOf(store, 4)];
  store.set({ trim: { ...store.state.trim, start: 3, frames: 13 } });
  await app.rerun();
  assert.equal(store.state.timeline.numFrames, 13);
  // The frame that was the fifth.
  const carriedOver = regionsOf(store, 1);
  assert.deepEqual(Object.keys(carriedOver), ['0', '1', '2']);
  assert.deepEqual(carriedOver[2], objects[2]);
  for (const axis of ['x', 'y']) assert.ok(Math.abs(carriedOver[1][axis] - objects[1][axis]) < 2);
  assert.equal(store.state.notice, 'These corrections no longer apply (undo restores them): erasing in frame 2.');
  await app.restore();
  assert.equal(masksOf(store), before);
  assert.equal(store.state.notice, '');
});

test('a run at another size has corrections at the same places', async () => {
  const { app, store } = await openRun(movingFrames(6, [200, 130]));
  await paint(store, { t: 4, from: [0.5, 0.7], to: [0.8, 0.7] });
  const newest = () => Object.values(regionsOf(store, 4)).at(-1);
  const before = newest();
  store.set({ trim: { ...store.state.trim, side: 160 } });
  await app.rerun();
  const resized = newest();
  assert.ok(Math.abs(resized.area / (0.64 * before.area) - 1) < 0.05, `${resized.area} of ${before.area} pixels`);
  for (const axis of ['x', 'y']) assert.ok(Math.abs(resized[axis] - 0.8 * before[axis]) < 1);
  assert.doesNotMatch(store.state.notice, /no longer/);
});

test('a run in several windows keeps corrections', async () => {
  const { app, store } = await openRun(movingFrames(52, [88, 56]));
  assert.match(store.state.subline, /in \d windows/);
  await paint(store, { ...NEW_OBJECT, isCarried: false });
  await show(store, store.state.job.corrections.join(0, [1]));
  const before = masksOf(store);
  await app.rerun();
  assert.equal(masksOf(store), before);
  await app.restore();
  assert.equal(masksOf(store), before);
});

test('a cancelled run that is started again keeps corrections', async () => {
  const { app, store } = await openRun();
  await paint(store, NEW_OBJECT);
  const before = masksOf(store);
  const running = app.rerun();
  await waitForState(store, ({ phase, share }) => phase === 'running' && share > 0);
  app.cancel();
  await running;
  assert.equal(store.state.phase, 'stopped');
  await app.rerun();
  assert.equal(store.state.phase, 'done');
  assert.equal(masksOf(store), before);
});

test('undo restores masks and settings of the last finished run, also without corrections', async () => {
  const { app, store } = await openRun(movingFrames(8, [96, 64]));
  const first = store.state.job;
  const [before, { trim }] = [masksOf(store), store.state];
  store.set({ changed: new Map([['trajectory.gridStep', 12]]), trim: { ...trim, frames: 6 } });
  await app.rerun();
  assert.equal(store.state.timeline.numFrames, 6);
  assert.equal(store.state.previousJob, first);
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
  assert.equal(masksOf(store), before);
  store.set({ changed: new Map([['trajectory.gridStep', 12]]) });
  await app.rerun();
  await app.restore();
  assert.equal(masksOf(store), before);
  assert.deepEqual([store.state.changed.size, store.state.phase], [0, 'done']);
});

test('a run asks before it replaces corrections; later ones are undone first', async () => {
  const { app, store } = await openRun();
  await paint(store, NEW_OBJECT);
  store.set({ hidden: new Set([1]) });
  const before = masksOf(store);
  const { job } = store.state;
  app.confirmRerun = async () => false;
  await app.rerun();
  assert.equal(store.state.job, job);
  app.confirmRerun = async () => true;
  await app.rerun();
  assert.equal(masksOf(store), before);
  assert.deepEqual([...store.state.hidden], [1]);
  const { corrections } = store.state.job;
  assert.equal(corrections.undoCount(), 0, 'what was carried over is one step with the run');
  await paint(store, { t: 4, from: [0.3, 0.5], to: [0.3, 0.7], label: 0 });
  assert.notEqual(masksOf(store), before);
  await show(store, corrections.undo());
  assert.equal(masksOf(store), before);
  assert.equal(store.state.previousJob, job);
});

test('a run repeats corrections of all kinds, and each can be undone after it was restored', async () => {
  const { app, store } = await openModel();
  await app.openFiles([CLIP]);
  const before = masksOf(store);
  const change = (act) => show(store, act(store.state.job.corrections));
  await change((corrections) => corrections.join(1, [2]));
  await change((corrections) => corrections.split(1));
  await change((corrections) => corrections.joinStrokes([1, 3].map((object) => strokeOn(store, 8, object))));
  await change((corrections) => corrections.join(0, [2]));
  const corrected = masksOf(store);
  assert.notEqual(corrected, before);
  await app.rerun();
  assert.equal(masksOf(store), corrected);
  assert.equal(store.state.notice, '');
  await app.restore();
  for (let step = 0; step < 4; step += 1) await change((corrections) => corrections.undo());
  assert.equal(masksOf(store), before);
});
