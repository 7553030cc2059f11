// The regions that a click with Add would take: outlined where the pointer rests, in the size that the user chooses.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { encodeRuns } from 'tracecut/edit';
import { Brush, NEW_OBJECT } from '../../build/model/brush.js';
import { Candidates } from '../../build/model/candidates.js';
import { showCorrected } from '../../build/model/show-result.js';
import { traceRegion } from '../../build/model/outline.js';
import { Store } from '../../build/model/store.js';
import { openSampleWork } from './studio.mjs';

async function until(isTrue) {
  for (let k = 0; k < 2000 && !isTrue(); k += 1) await new Promise((resolve) => setTimeout(resolve, 5));
  assert.ok(isTrue());
}

/** A corrector whose features are ready when the test says so. */
function slowCorrector() {
  const asked = new Map();
  const frameFeatures = (t) => {
    if (!asked.has(t)) {
      const features = {};
      features.ready = new Promise((resolve) => (features.resolve = resolve));
      asked.set(t, features);
    }
    return asked.get(t).ready;
  };
  const growRegions = async () => ({
    regions: [
      [1, 1, 0, 0],
      [1, 1, 1, 0],
    ].map((pixels) => encodeRuns(Uint8Array.from(pixels))),
    likeliest: 1,
  });
  return { frames: () => [...asked.keys()], ready: (t) => asked.get(t).resolve(), frameFeatures, growRegions };
}

/** A store with one frame shape of 2 × 2 pixels, all of them background. */
function smallStore() {
  const store = new Store();
  const segmentation = { result: { width: 2 }, mask: () => new Uint8Array(4) };
  store.set({ analysis: { segmentation, facts: [], frameData: {} } });
  return store;
}

test('a click takes exactly the outlined region, in the chosen size, or removes it', async () => {
  const { store } = await openSampleWork();
  const { corrections } = store.state.job;
  const mask = () => store.state.analysis.segmentation.mask(6);
  const change = async (promise) => showCorrected(store, await promise);
  // The largest object is missed.
  const pixelsOf = (object) => [...mask().keys()].filter((p) => mask()[p] === object);
  const objects = [...new Set(mask())].filter((object) => object > 0);
  const label = objects.reduce((a, b) => (pixelsOf(b).length > pixelsOf(a).length ? b : a));
  const pixels = pixelsOf(label);
  const { width } = store.state.analysis.segmentation.result;
  const mean = (valueOf) => pixels.reduce((sum, p) => sum + valueOf(p), 0) / pixels.length;
  const place = { x: mean((p) => p % width), y: mean((p) => Math.floor(p / width)) };
  await change(corrections.join(0, [label]));
  store.set({ frame: 6 });

  let object = NEW_OBJECT;
  const brush = new Brush({
    store,
    corrector: () => corrections,
    object: () => object,
    choose: (chosen) => (object = chosen),
    appliesToOthers: () => false,
    onCarrying() {},
    onSizes() {},
    showFrames: (frames) => showCorrected(store, frames),
    showStatus() {},
  });
  const candidates = new Candidates({ store, corrector: () => corrections, onChange() {} });
  const outlinedArea = () => candidates.outlined.list[candidates.outlined.at].area;
  candidates.turn(true);
  candidates.aimAt({ ...place, t: 6, object: 0, isRemoving: false });
  await until(() => candidates.outlined);
  const { list, at } = candidates.outlined;
  assert.ok(list.length > 1, 'there are sizes to choose from');
  candidates.resize(at > 0 ? -1 : 1);
  assert.notEqual(candidates.outlined.at, at);
  const { at: chosen } = candidates.outlined;
  candidates.aimAt({ ...place, x: place.x + 0.2, t: 6, object: 0, isRemoving: false });
  assert.equal(candidates.outlined.at, chosen, 'the size stays while the pointer is inside');

  const before = mask().slice();
  const { pixels: outlined } = candidates.outlined.list[chosen];
  brush.add(place, 0, false, candidates.take(6, false));
  await brush.queue;
  assert.ok(object > 0);
  assert.deepEqual(
    mask(),
    before.map((old, p) => (outlined[p] ? object : old)),
  );
  assert.equal(candidates.outlined, null, 'nothing is outlined until the pointer moves');
  assert.equal(brush.offer, null, 'the size was chosen before the click');

  candidates.aimAt({ ...place, t: 6, object, isRemoving: true });
  await until(() => candidates.outlined);
  assert.ok(outlinedArea() > 0);
  assert.equal(candidates.take(6, false), null, 'a click without Alt does not take it');
  candidates.aimAt({ ...place, x: place.x + 1, t: 6, object, isRemoving: true });
  await until(() => candidates.outlined);
  const removed = candidates.outlined.list[candidates.outlined.at].pixels;
  const added = mask().slice();
  brush.add(place, object, true, candidates.take(6, true));
  await brush.queue;
  assert.deepEqual(
    mask(),
    added.map((old, p) => (removed[p] ? 0 : old)),
  );
});

test('the features of a frame are computed once, and those of frames that were left are skipped', async () => {
  const store = smallStore();
  const corrector = slowCorrector();
  const candidates = new Candidates({ store, corrector: () => corrector, onChange() {} });
  candidates.turn(true);
  for (const frame of [1, 2, 3]) store.set({ frame });
  candidates.aimAt({ t: 3, x: 0, y: 0, object: 0, isRemoving: false });
  assert.deepEqual(corrector.frames(), [0]);
  corrector.ready(0);
  await until(() => corrector.frames().length === 2);
  assert.equal(candidates.outlined, null, 'features of another frame outline nothing');
  corrector.ready(3);
  await until(() => candidates.outlined);
  assert.deepEqual(corrector.frames(), [0, 3]);
  assert.deepEqual([candidates.outlined.aim.t, candidates.outlined.at], [3, 1]);
  candidates.turn(false);
  assert.equal(candidates.outlined, null);
  store.set({ frame: 7 });
  assert.equal(corrector.frames().length, 2, 'nothing is computed for other tools');
});

test('corrections keep the features of two frames', async () => {
  const { store } = await openSampleWork();
  const { corrections } = store.state.job;
  const computed = [];
  corrections.imageEngine = async () => ({
    superpixels: async () => computed.push('superpixels'),
    flow: async () => computed.push('flow'),
  });
  for (const t of [3, 4, 3, 4]) await corrections.frameFeatures(t);
  assert.equal(computed.length, 4);
  await corrections.frameFeatures(5);
  await corrections.frameFeatures(4);
  assert.equal(computed.length, 6);
  await corrections.frameFeatures(3);
  assert.equal(computed.length, 8);
});

test('outlines are closed lines, also around holes and at the border', () => {
  const ring = [1, 1, 1, 1, 0, 1, 1, 1, 1];
  const lines = traceRegion(ring, 3, 3);
  assert.deepEqual(
    lines.map((line) => line.length / 2),
    [12, 4],
  );
  assert.ok(
    lines[1].every((value) => value >= 0.5 && value <= 1.5),
    'the hole',
  );
  assert.ok(lines[0].every((value) => value >= -0.5 && value <= 2.5));
  assert.deepEqual(traceRegion([0, 0, 0, 0], 2, 2), []);
});
