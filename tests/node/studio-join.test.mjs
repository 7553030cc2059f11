// Joined objects: which are kept, also after undo, and which are proposed.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { findSimilarObjects } from '../../build/model/similar-objects.js';
import { showCorrected } from '../../build/model/show-result.js';
import { openSampleWork } from './studio.mjs';

test('a join keeps the object if a part was kept, by strokes too, and undo hides what was hidden before', async () => {
  const { store, selection } = await openSampleWork();
  const hidden = () => [...store.state.hidden].sort();
  const change = async (promise) => showCorrected(store, await promise);
  const mask = store.state.analysis.segmentation.mask(6);
  const { width } = store.state.analysis.segmentation.result;
  const strokeOn = (object) => {
    const pixels = [...mask.keys()].filter((p) => mask[p] === object);
    const p = pixels[pixels.length >> 1];
    return { t: 6, points: [p % width, Math.floor(p / width)], radius: 1 };
  };
  for (const join of [() => selection.join(1, [2]), () => selection.joinStrokes([strokeOn(1), strokeOn(2)])]) {
    store.set({ hidden: new Set([2, 3]) });
    await change(join());
    assert.deepEqual(hidden(), [3]);
    // What the user hides meanwhile stays.
    store.set({ hidden: new Set() });
    await change(selection.undo());
    assert.deepEqual(hidden(), [2]);
    await change(selection.redo());
    assert.deepEqual(hidden(), []);
    await change(selection.undo());
    store.set({ hidden: new Set([1, 2]) });
    await change(join());
    assert.deepEqual(hidden(), [1, 2].slice(0, hidden().length), 'of two hidden parts nothing is kept');
    assert.ok(hidden().includes(1));
    await change(selection.undo());
    assert.deepEqual(hidden(), [1, 2]);
  }
  store.set({ hidden: new Set([3]) });
  await change(selection.join(0, [3]));
  await change(selection.undo());
  assert.deepEqual(hidden(), [3], 'also the highest label, which was gone');
  await change(selection.undo());
  assert.deepEqual(hidden(), [3], 'nothing is left to undo');
});

/** A clip of 8 × 8 pixels in which objects are squares: at these frames and this column. */
function clipOf(objects, cuts = []) {
  const frames = 6;
  const labels = (t) => {
    const mask = new Uint8Array(64);
    for (const { object, first, last, x } of objects)
      if (first <= t && t <= last) for (let p = 0; p < 16; p += 1) mask[8 * (2 + (p >> 2)) + x + (p & 3)] = object;
    return mask;
  };
  const trajectories = { count: 0, startFrame: [], offset: [0], x: [], y: [] };
  const scene = { x: new Float32Array(frames + 1), y: new Float32Array(frames + 1) };
  return { width: 8, height: 8, numFrames: frames, labels, trajectories, scene, spans: objects, cuts };
}

test('objects are proposed of which one begins where and when the other ends', () => {
  const parted = [
    { object: 1, first: 0, last: 1, x: 0 },
    { object: 2, first: 2, last: 3, x: 1 },
    { object: 3, first: 4, last: 5, x: 1 },
  ];
  assert.deepEqual(
    findSimilarObjects(clipOf(parted)).map((group) => group.sort()),
    [[1, 2, 3]],
  );
  assert.deepEqual(
    findSimilarObjects(clipOf(parted, [2])).map((group) => group.sort()),
    [[2, 3]],
    'not beyond a cut',
  );
  const elsewhere = parted.map((object) => ({ ...object, x: 2 * object.object - 2 }));
  assert.deepEqual(findSimilarObjects(clipOf(elsewhere)), []);
  const later = [parted[0], { ...parted[1], first: 3 }];
  assert.deepEqual(findSimilarObjects(clipOf(later)), [], 'another may have come meanwhile');
});
