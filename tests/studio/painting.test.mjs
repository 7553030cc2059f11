// Painting in the studio: objects are added, painted, erased and split, in all windows of a clip; the range of a fix; the
// regions that a click with Add would take.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { encodeRuns } from 'tracecut/edit';
import { NEW_OBJECT } from '../../build/model/brush.js';
import { Candidates, traceRegion } from '../../build/model/candidates.js';
import { Store } from '../../build/model/store.js';
import { movingFrames } from '../moving.mjs';
import { CLIP, createBrush, maskAt, masksOf, openModel, openSampleWork, pixelsOf, regionsOf, show } from './studio.mjs';

test('adds, paints, splits and erases in all windows of a clip, and undoes each step', async () => {
  const { app, store } = await openModel(movingFrames(52, [88, 56]));
  await app.openFiles([CLIP]);
  assert.match(store.state.subline, /in 2 windows/);
  const { corrections } = store.state.job;
  const { brush, panel } = createBrush(store, NEW_OBJECT);
  const labelAt = (t, x, y) => store.state.analysis.segmentation.objectAt(t, x, y);
  const before = masksOf(store);

  store.set({ frame: 50 });
  await brush.add({ x: 76, y: 14 }, 0, false);
  await brush.queue;
  assert.equal(panel.texts.at(-1), 'Applied to frames 1–52.');
  for (const t of [0, 30, 50, 51]) assert.equal(labelAt(t, 76, 14), panel.object, `frame ${t}`);
  const added = masksOf(store);
  if (panel.canGrow) {
    await brush.resize(1);
    await brush.queue;
    assert.notEqual(masksOf(store), added);
    await brush.resize(-1);
    await brush.queue;
    assert.equal(masksOf(store), added);
    assert.equal(corrections.undoCount(), 1);
  }

  brush.stroke({ t: 50, points: [66, 14, 70, 14], radius: 3 }, 'paint');
  await brush.queue;
  const paintedMasks = masksOf(store);
  for (let step = 0; step < 2; step += 1) await show(store, corrections.undo());
  assert.equal(masksOf(store), before);
  for (let step = 0; step < 2; step += 1) await show(store, corrections.redo());
  assert.equal(masksOf(store), paintedMasks);

  // Two strokes split the square; two join it again.
  const halves = (t, squareX) => [labelAt(t, squareX + 4, 38), labelAt(t, squareX + 22, 38)];
  const [label] = halves(50, 40);
  const line = (x) => ({ t: 50, points: [x, 30, x, 46], radius: 2 });
  await show(store, corrections.splitStrokes([line(44), line(62)]));
  const [first, second] = halves(50, 40);
  assert.equal(first, label);
  assert.ok(second > 0 && second !== first);
  const squares = { 30: 40, 45: 45, 51: 39 };
  for (const [t, x] of Object.entries(squares)) assert.deepEqual(halves(Number(t), x), [first, second], t);
  const split = masksOf(store);
  await show(store, corrections.joinStrokes([line(44), line(62)]));
  assert.deepEqual(halves(51, 39), [first, first]);
  await show(store, corrections.undo());
  assert.equal(masksOf(store), split);

  panel.object = first;
  brush.stroke({ t: 50, points: [44, 30, 44, 46], radius: 2 }, 'erase');
  await brush.queue;
  assert.equal(labelAt(50, 44, 38), 0);
  while (corrections.undoCount() > 0) await show(store, corrections.undo());
  assert.equal(masksOf(store), before);
});

test('trims and extends the range of a fix in one step of undo, until the next step', async () => {
  const { store, corrections } = await openSampleWork();
  const { brush, panel } = createBrush(store, 9);
  const range = () => [store.state.fix?.first, store.state.fix?.last];
  const paintedFrames = () => Array.from({ length: 16 }, (_, t) => t).filter((t) => maskAt(store, t).includes(9));
  const between = (first, last) => Array.from({ length: last - first + 1 }, (_, k) => first + k);
  const lengths = [];
  store.watch(['fix'], ({ fix }) => fix?.isSpreading && lengths.push(fix.last - fix.first));
  const before = masksOf(store);
  const stroke = { t: 8, points: [20, 20, 40, 20], radius: 6 };
  store.set({ frame: 8 });
  brush.stroke(stroke, 'paint');
  await brush.queue;
  const [first, last] = range();
  assert.ok(first < 6 && last > 10, `${first} to ${last}`);
  const { object, t, isSpreading } = store.state.fix;
  assert.deepEqual({ object, t, isSpreading }, { object: 9, t: 8, isSpreading: false });
  assert.deepEqual(paintedFrames(), between(first, last));
  assert.ok(lengths.some((length) => length > 0 && length < last - first));

  for (const [from, to] of [
    [7, 10],
    [7, 13],
    [5, 8],
  ]) {
    await brush.moveEnds({ first: from, last: to });
    assert.deepEqual(range(), [from, to]);
    assert.deepEqual(paintedFrames(), between(from, to));
    assert.equal(panel.texts.at(-1), `Applied to frames ${from + 1}–${to + 1}.`);
  }
  assert.equal(corrections.undoCount(), 1);
  await show(store, corrections.undo());
  assert.equal(store.state.fix, null);
  assert.equal(masksOf(store), before);

  brush.stroke(stroke, 'paint');
  await brush.queue;
  const { edit } = store.state.fix;
  await show(store, corrections.join(1, [2]));
  assert.equal(store.state.fix, null);
  await brush.applyEnds(edit, { first: 8, last: 8 }, store.state.visit);
  assert.ok(paintedFrames().length > 1, 'an earlier step keeps its frames');
});

test('says that a stroke stays in its frame where other frames are uncertain', async () => {
  const { store, corrections } = await openSampleWork();
  const { brush, panel } = createBrush(store, 2);
  corrections.openEditor.carry = async () => {};
  brush.stroke({ t: 12, points: [14, 21, 28, 24], radius: 3 }, 'paint');
  await brush.queue;
  const advice = 'other frames are uncertain; drag the ends of the range to add some';
  assert.equal(panel.texts.at(-1), `Applied to frame 13 only: ${advice}.`);
  const single = createBrush(store, 2, { isCarrying: false });
  single.brush.stroke({ t: 12, points: [14, 21, 28, 24], radius: 3 }, 'erase');
  await single.brush.queue;
  assert.equal(single.panel.texts.at(-1), 'Applied to frame 13.');
});

/** Returns candidates of a store, and `nextChange()`, which resolves when another region or none is outlined. */
function createCandidates(store, corrector) {
  let resolveChange = () => {};
  const candidates = new Candidates({ store, corrector: () => corrector, onChange: () => resolveChange() });
  candidates.turn(true);
  return { candidates, nextChange: () => new Promise((resolve) => (resolveChange = resolve)) };
}

test('takes exactly the outlined region with a click, in the chosen size, or removes it', async () => {
  const { store, corrections } = await openSampleWork();
  const regions = regionsOf(store, 6);
  const largest = Object.keys(regions)
    .map(Number)
    .filter((label) => label > 0)
    .reduce((a, b) => (regions[b].area > regions[a].area ? b : a));
  const place = { x: regions[largest].x, y: regions[largest].y };
  await show(store, corrections.join(0, [largest]));
  store.set({ frame: 6 });
  const { brush, panel } = createBrush(store, NEW_OBJECT, { isCarrying: false });
  const { candidates, nextChange } = createCandidates(store, corrections);
  const outline = async (aim) => {
    const change = nextChange();
    candidates.aimAt({ ...place, t: 6, isRemoving: false, ...aim });
    await change;
    return candidates.outlined.list[candidates.outlined.at];
  };
  await outline({ object: 0 });
  const { list, at } = candidates.outlined;
  assert.ok(list.length > 1);
  candidates.resize(at > 0 ? -1 : 1);
  const { at: chosenIndex } = candidates.outlined;
  assert.notEqual(chosenIndex, at);
  candidates.aimAt({ ...place, x: place.x + 0.2, t: 6, object: 0, isRemoving: false });
  assert.equal(candidates.outlined.at, chosenIndex, 'the size stays while the pointer is inside');

  const before = maskAt(store, 6).slice();
  const { pixels } = candidates.outlined.list[chosenIndex];
  brush.add(place, 0, false, candidates.take(6, false));
  await brush.queue;
  const { object } = panel;
  assert.ok(object > 0);
  const expected = before.map((label, p) => (pixels[p] ? object : label));
  assert.deepEqual(maskAt(store, 6), expected);
  assert.equal(candidates.outlined, null);
  assert.equal(brush.offer, null, 'the size was chosen before the click');

  const { area } = await outline({ object, isRemoving: true });
  assert.ok(area > 0);
  assert.equal(candidates.take(6, false), null, 'a click without Alt does not take it');
  const { pixels: removed } = await outline({ x: place.x + 1, object, isRemoving: true });
  const added = maskAt(store, 6).slice();
  brush.add(place, object, true, candidates.take(6, true));
  await brush.queue;
  assert.deepEqual(
    maskAt(store, 6),
    added.map((label, p) => (removed[p] ? 0 : label)),
  );
});

test('lets an added object become larger or smaller after the click', async () => {
  const { store, corrections } = await openSampleWork();
  const [object] = Object.keys(regionsOf(store, 6)).map(Number).filter(Boolean);
  const { x, y } = regionsOf(store, 6)[object];
  await show(store, corrections.join(0, [object]));
  store.set({ frame: 6 });
  const { brush, panel } = createBrush(store, NEW_OBJECT, { isCarrying: false });
  await brush.add({ x, y }, 0, false);
  await brush.queue;
  const added = panel.object;
  const area = pixelsOf(store, 6, added).length;
  const isLarger = panel.canGrow;
  assert.ok(isLarger || panel.canShrink);
  await brush.resize(isLarger ? 1 : -1);
  await brush.queue;
  const change = pixelsOf(store, 6, added).length - area;
  assert.ok(isLarger ? change > 0 : change < 0, `${change} pixels`);
  assert.equal(corrections.undoCount(), 2);
});

test('computes the features of a frame once, and skips frames that were left meanwhile', async () => {
  const store = new Store();
  const segmentation = { result: { width: 2 }, mask: () => new Uint8Array(4) };
  store.set({ analysis: { segmentation, facts: [], frameData: {} } });
  // The features of a frame are ready when the test says so.
  const requests = new Map();
  let onRequest = () => {};
  const corrector = {
    frameFeatures(t) {
      if (!requests.has(t)) {
        const request = {};
        request.promise = new Promise((resolve) => (request.resolve = resolve));
        requests.set(t, request);
      }
      onRequest(t);
      return requests.get(t).promise;
    },
    growRegions: async () => ({
      regions: ['1100', '1110'].map((pixels) => encodeRuns(Uint8Array.from(pixels, Number))),
      likeliest: 1,
    }),
  };
  const { candidates, nextChange } = createCandidates(store, corrector);
  for (const frame of [1, 2, 3]) store.set({ frame });
  candidates.aimAt({ t: 3, x: 0, y: 0, object: 0, isRemoving: false });
  assert.deepEqual([...requests.keys()], [0]);
  const second = new Promise((resolve) => (onRequest = resolve));
  requests.get(0).resolve();
  assert.equal(await second, 3);
  assert.equal(candidates.outlined, null, 'features of another frame outline nothing');
  const outlined = nextChange();
  requests.get(3).resolve();
  await outlined;
  assert.deepEqual([candidates.outlined.aim.t, candidates.outlined.at], [3, 1]);
  candidates.turn(false);
  assert.equal(candidates.outlined, null);
  store.set({ frame: 7 });
  assert.deepEqual([...requests.keys()], [0, 3], 'other tools need no features');
});

test('keeps the features of two frames', async () => {
  const { store, corrections } = await openSampleWork();
  let calls = 0;
  const count = async () => (calls += 1);
  corrections.imageEngine = async () => ({ superpixels: count, flow: count });
  for (const [t, expected] of [
    [3, 2],
    [4, 4],
    [3, 4],
    [4, 4],
    [5, 6],
    [4, 6],
    [3, 8],
  ]) {
    await corrections.frameFeatures(t);
    assert.equal(calls, expected);
  }
});

test('traces regions as closed lines, also around holes and at the border', () => {
  const [border, hole] = traceRegion([1, 1, 1, 1, 0, 1, 1, 1, 1], 3, 3);
  assert.deepEqual([border.length / 2, hole.length / 2], [12, 4]);
  assert.ok(hole.every((value) => value >= 0.5 && value <= 1.5));
  assert.ok(border.every((value) => value >= -0.5 && value <= 2.5));
  assert.deepEqual(traceRegion([0, 0, 0, 0], 2, 2), []);
});
