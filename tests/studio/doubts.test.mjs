// The places to check: going from one to the next, accepting and repairing them; how sure the masks are.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  acceptDoubt,
  describeDoubts,
  describeObstacle,
  doubtAt,
  repairDoubt,
  showNextDoubt,
} from '../../build/model/doubts.js';
import { showCorrected } from '../../build/model/show-result.js';
import { maskAt } from './editing.mjs';
import { openModel, openSampleWork } from './studio.mjs';

const DOUBTS = [
  { from: 0, to: 3 },
  { from: 8, to: 12 },
];

test('places to check are shown one after the other; accepted ones come back only with another run', async () => {
  const { app, store } = await openModel();
  await app.openSample();
  const { job, timeline } = store.state;
  assert.equal(store.state.agreement.length, timeline.numFrames);
  assert.deepEqual(store.state.agreement, (await job.outputs.agreement()).frames);
  assert.deepEqual(store.state.doubts, job.result.doubts);
  Object.defineProperty(job.result, 'doubts', { value: DOUBTS });
  job.agreement = null;
  showCorrected(store);
  assert.equal(store.state.agreement, null);
  assert.deepEqual(store.state.doubts, DOUBTS);
  const visited = Array.from({ length: 3 }, () => {
    showNextDoubt(store);
    return store.state.frame;
  });
  assert.deepEqual(visited, [9, 1, 9]);
  assert.equal(doubtAt(store.state), 1);
  acceptDoubt(store);
  assert.deepEqual([store.state.doubts, store.state.frame], [[DOUBTS[0]], 1]);
  showCorrected(store);
  assert.deepEqual(store.state.doubts, [DOUBTS[0]]);
  // Nothing is accepted on a frame outside of the places.
  store.set({ frame: 7 });
  acceptDoubt(store);
  assert.deepEqual([store.state.doubts, store.state.frame], [[DOUBTS[0]], 7]);
  store.set({ frame: 2 });
  acceptDoubt(store);
  showNextDoubt(store);
  assert.deepEqual([store.state.doubts, doubtAt(store.state)], [[], -1]);

  await app.rerun();
  assert.deepEqual([store.state.fine, store.state.doubts], [new Set(), store.state.job.result.doubts]);
});

test('a place is repaired from its neighbours, or from there to the end of the shot, and is accepted', async () => {
  const { store } = await openSampleWork();
  const { job } = store.state;
  const { openEditor } = job.corrections;
  Object.defineProperty(job.result, 'doubts', { value: [DOUBTS[1], { from: 13, to: 14 }] });
  showCorrected(store);
  const requests = [];
  // Paints in the first frame instead of interpolating.
  openEditor.interpolate = async (range, { sides, onFrame }) => {
    requests.push({ ...range, sides });
    onFrame({ t: range.from });
    return openEditor.paint({ label: 7, stroke: { t: range.from, points: [20, 20], radius: 5 } });
  };
  store.set({ frame: 9, timeline: { ...store.state.timeline, cuts: [6, 14] } });
  let frames = 0;
  const options = { signal: new AbortController().signal, onFrame: () => (frames += 1) };
  const repaired = { from: 8, to: 9 };
  assert.deepEqual(await repairDoubt(store, DOUBTS[1], 'both', options), repaired, 'only the frames that changed');
  assert.deepEqual([store.state.doubts, store.state.fine], [[{ from: 13, to: 14 }], new Set([8])]);
  assert.equal(store.state.frame, 9, 'the repaired frames stay on screen');
  assert.ok(maskAt(store, 8).includes(7));
  assert.deepEqual(await repairDoubt(store, { from: 8, to: 12 }, 'before', options), repaired);
  assert.deepEqual(requests, [
    { from: 8, to: 12, sides: 'both' },
    { from: 8, to: 14, sides: 'before' },
  ]);
  assert.equal(frames, 2);
  assert.equal(job.corrections.undoCount(), 2);

  // Another clip is not touched.
  openEditor.interpolate = async () => {
    store.set({ visit: store.state.visit + 1 });
    return openEditor.paint({ label: 7, stroke: { t: 13, points: [20, 20], radius: 5 } });
  };
  assert.equal(await repairDoubt(store, { from: 13, to: 14 }, 'both', options), null);
  assert.equal(store.state.doubts.length, 1);
});

test('texts count the places, and say why one cannot be repaired', () => {
  assert.deepEqual([0, 1, 4].map(describeDoubts), ['', '1 place to check', '4 places to check']);
  const timeline = { numFrames: 16, cuts: [6] };
  const obstacles = (from, to) =>
    ['both', 'before'].map((repair) => describeObstacle({ timeline }, { from, to }, repair));
  assert.deepEqual(obstacles(2, 4), ['', '']);
  assert.deepEqual(obstacles(0, 4), Array(2).fill('There is no frame before these.'));
  assert.deepEqual(obstacles(6, 8), Array(2).fill('There is a cut before these frames.'));
  assert.deepEqual(obstacles(4, 6), ['There is a cut after these frames.', '']);
  assert.deepEqual(obstacles(12, 16), ['There is no frame after these.', '']);
});
