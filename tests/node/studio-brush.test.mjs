// Painting in the studio: things are added, painted, wiped away and parted, in all windows of a clip.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Brush, NEW_OBJECT } from '../../build/model/brush.js';
import { showCorrected } from '../../build/model/show-result.js';
import { movingFrames } from '../moving.mjs';
import { CLIP, openModel, openSampleWork } from './studio.mjs';

test('in a clip of three windows things are added, painted and parted, and each step is undone', async () => {
  const { app, store } = await openModel(movingFrames(110, [96, 64]));
  await app.openFiles([CLIP]);
  assert.match(store.state.subline, /in 3 windows/);
  const { corrections } = store.state.job;
  const told = [];
  let [object, sizes] = [NEW_OBJECT, []];
  const brush = new Brush({
    store,
    corrector: () => corrections,
    object: () => object,
    choose: (label) => (object = label),
    appliesToOthers: () => true,
    onCarrying() {},
    onSizes: (...both) => (sizes = both),
    showFrames: (frames) => showCorrected(store, frames),
    showStatus: (text) => told.push(text),
  });
  const masks = () =>
    Array.from({ length: 110 }, (_, t) => store.state.analysis.segmentation.mask(t).join('')).join('|');
  const labelAt = (t, x, y) => store.state.analysis.segmentation.objectAt(t, x, y);
  const change = async (promise) => showCorrected(store, await promise);
  const before = masks();

  store.set({ frame: 55 });
  await brush.add({ x: 76, y: 14 }, 0, false);
  await brush.queue;
  assert.equal(told.at(-1), 'Applied to frames 1–110.');
  assert.equal(labelAt(55, 76, 14), object);
  for (const t of [0, 30, 109]) assert.equal(labelAt(t, 76, 14), object, `frame ${t}`);
  const added = masks();
  if (sizes[1]) {
    await brush.resize(1);
    await brush.queue;
    assert.notEqual(masks(), added);
    await brush.resize(-1);
    await brush.queue;
    assert.equal(masks(), added, 'another size is no step of its own');
    assert.equal(corrections.undoCount(), 1);
  }

  brush.stroke({ t: 55, points: [66, 14, 70, 14], radius: 3 }, 'paint');
  await brush.queue;
  const painted = masks();
  for (const _ of [0, 1]) await change(corrections.undo());
  assert.equal(masks(), before);
  for (const _ of [0, 1]) await change(corrections.redo());
  assert.equal(masks(), painted);

  // The square is taken apart by two strokes, in all windows; and put together again.
  const halves = (t, left) => [labelAt(t, left + 4, 38), labelAt(t, left + 22, 38)];
  const [whole] = halves(55, 35);
  const line = (x) => ({ t: 55, points: [x, 30, x, 46], radius: 2 });
  await change(corrections.splitStrokes([line(39), line(57)]));
  const [one, other] = halves(55, 35);
  assert.ok(one === whole && other > 0 && other !== one, `${one} and ${other}`);
  for (const [t, left] of [
    [50, 40],
    [70, 20],
    [100, 30],
  ])
    assert.deepEqual(halves(t, left), [one, other], `frame ${t}`);
  const apart = masks();
  await change(corrections.joinStrokes([line(39), line(57)]));
  assert.deepEqual(halves(100, 30), [one, one]);
  await change(corrections.undo());
  assert.equal(masks(), apart);

  object = one;
  brush.stroke({ t: 55, points: [39, 30, 39, 46], radius: 2 }, 'erase');
  await brush.queue;
  assert.equal(labelAt(55, 39, 38), 0);
  while (corrections.undoCount() > 0) await change(corrections.undo());
  assert.equal(masks(), before);
});

test('the range of a fix follows it, is trimmed and carried on in one step of undo, and ends with the next step', async () => {
  const { store } = await openSampleWork();
  const { corrections } = store.state.job;
  const told = [];
  const ranges = [];
  const brush = new Brush({
    store,
    corrector: () => corrections,
    object: () => 9,
    choose() {},
    appliesToOthers: () => true,
    onCarrying() {},
    onSizes() {},
    showFrames: (frames) => showCorrected(store, frames),
    showStatus: (text) => told.push(text),
  });
  const range = () => [store.state.fix?.first, store.state.fix?.last];
  const maskAt = (t) => store.state.analysis.segmentation.mask(t);
  const framesWith = () => Array.from({ length: 16 }, (_, t) => t).filter((t) => maskAt(t).includes(9));
  const between = (first, last) => Array.from({ length: last - first + 1 }, (_, k) => first + k);
  store.watch(['fix'], ({ fix }) => fix && ranges.push([fix.last - fix.first, fix.isSpreading]));
  const before = Array.from({ length: 16 }, (_, t) => maskAt(t).join(''));
  store.set({ frame: 8 });
  brush.stroke({ t: 8, points: [20, 20, 40, 20], radius: 6 }, 'paint');
  await brush.queue;
  const [first, last] = range();
  assert.ok(first < 6 && last > 10, `${first} to ${last}`);
  assert.deepEqual([store.state.fix.object, store.state.fix.t, store.state.fix.isSpreading], [9, 8, false]);
  assert.deepEqual(framesWith(), between(first, last));
  assert.ok(
    ranges.some(([length, isSpreading]) => isSpreading && length > 0 && length < last - first),
    'it grows live',
  );

  await brush.moveEnds({ first: 7, last: 10 });
  assert.deepEqual(
    [range(), framesWith()],
    [
      [7, 10],
      [7, 8, 9, 10],
    ],
  );
  assert.equal(told.at(-1), 'Applied to frames 8–11.');
  await brush.moveEnds({ first: 7, last: 13 });
  assert.deepEqual([range(), framesWith()], [[7, 13], between(7, 13)]);
  await brush.moveEnds({ first: 5, last: 8 });
  assert.deepEqual([range(), framesWith()], [[5, 8], between(5, 8)]);
  assert.equal(corrections.undoCount(), 1);
  showCorrected(store, await corrections.undo());
  assert.equal(store.state.fix, null);
  assert.deepEqual(
    Array.from({ length: 16 }, (_, t) => maskAt(t).join('')),
    before,
  );

  brush.stroke({ t: 8, points: [20, 20, 40, 20], radius: 6 }, 'paint');
  await brush.queue;
  const { edit } = store.state.fix;
  showCorrected(store, await corrections.join(1, [2]));
  assert.equal(store.state.fix, null, 'another correction ends it');
  await brush.applyEnds(edit, { first: 8, last: 8 }, store.state.visit);
  assert.ok(framesWith().length > 1, 'an earlier step keeps its frames');
});
