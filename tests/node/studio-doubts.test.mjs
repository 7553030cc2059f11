// The places to check: going from one to the next, and accepting them.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { acceptDoubt, describeDoubts, doubtAt, showNextDoubt } from '../../build/model/doubts.js';
import { showCorrected } from '../../build/model/show-result.js';
import { openModel } from './studio.mjs';

const DOUBTS = [
  { from: 0, to: 3 },
  { from: 8, to: 12 },
];

test('places to check are shown one after the other, and one that is fine does not come back', async () => {
  const { app, store } = await openModel();
  await app.openSample();
  const { job } = store.state;
  assert.deepEqual(store.state.doubts, job.result.doubts);
  Object.defineProperty(job.result, 'doubts', { value: DOUBTS });
  showCorrected(store);
  assert.deepEqual(store.state.doubts, DOUBTS);
  const visited = [];
  for (let k = 0; k < 3; k += 1) {
    showNextDoubt(store);
    visited.push(store.state.frame);
  }
  // After the last one the first.
  assert.deepEqual(visited, [9, 1, 9]);
  assert.equal(doubtAt(store.state), 1);
  acceptDoubt(store);
  assert.deepEqual([store.state.doubts, store.state.frame], [[DOUBTS[0]], 1]);
  showCorrected(store);
  assert.deepEqual(store.state.doubts, [DOUBTS[0]]);
  // Away from the places nothing is accepted.
  store.set({ frame: 7 });
  acceptDoubt(store);
  assert.deepEqual([store.state.doubts, store.state.frame], [[DOUBTS[0]], 7]);
  store.set({ frame: 2 });
  acceptDoubt(store);
  showNextDoubt(store);
  assert.deepEqual([store.state.doubts, doubtAt(store.state)], [[], -1]);

  // Another run begins without what was fine in this one.
  await app.rerun();
  assert.deepEqual([store.state.fine, store.state.doubts], [new Set(), store.state.job.result.doubts]);
});

test('the number of places is told', () => {
  assert.deepEqual([0, 1, 4].map(describeDoubts), ['', '1 place to check', '4 places to check']);
});
