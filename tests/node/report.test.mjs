// searchReport: counts by hand, and of a clip whose camera is known.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { searchReport, segmentVideo } from 'tracecut';
import { framesOf, plain, segment } from './support.mjs';

/** Two trajectories over three frames of 32 x 16: one rests, one goes 3 right and 4 down a frame. */
const two = {
  width: 32,
  height: 16,
  numFrames: 3,
  trajectories: { count: 2, offset: [0, 3, 6], x: [4, 4, 4, 20, 23, 26], y: [2, 2, 2, 3, 7, 11] },
  clusters: { count: 2, label: [1, 0] },
};

test('coverage, speed and motions come from the points', () => {
  assert.deepEqual(searchReport(two), {
    numFrames: 3,
    trajectories: 2,
    // One square for the point that rests, three for the other, of 16 by 8.
    coverage: 4 / 128,
    speed: 5,
    cameraMoves: true,
    motions: [0.5, 0.5],
  });
  const { motions, ...rest } = searchReport({ ...two, clusters: undefined });
  assert.equal(motions, null);
  assert.equal(rest.speed, 5);
});

test('a clip without texture has nothing that could be followed', async () => {
  const result = await segment(Array.from({ length: 5 }, () => plain(64, 48, 90)));
  assert.deepEqual(searchReport(result), {
    numFrames: 5,
    trajectories: 0,
    coverage: 0,
    speed: 0,
    cameraMoves: false,
    motions: [],
  });
});

test('a camera that pans is told from one that stands still, in one window and in many', async () => {
  const frames = await framesOf({ width: 160, height: 90, frames: 10, seed: 5 });
  const result = await segment(frames);
  assert.equal(searchReport(result).cameraMoves, true);
  const still = Array.from({ length: 10 }, () => frames[0]);
  const report = searchReport(await segment(still));
  assert.equal(report.cameraMoves, false);
  assert.ok(report.coverage > 0.5, `${report.coverage}`);
  const whole = await segmentVideo(frames, { window: 6, overlap: 2 }).collect();
  assert.equal(searchReport(whole).motions, null);
  assert.equal(searchReport(whole).cameraMoves, true);
});

test('what is no result is refused', () => {
  assert.throws(() => searchReport(null), { code: 'data', message: /result = null/ });
  assert.throws(() => searchReport({ ...two, trajectories: { ...two.trajectories, offset: [0] } }), {
    code: 'data',
    message: /1 entries \(expected 3\)/,
  });
});
