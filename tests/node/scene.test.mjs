// How the scene moves in the picture, against motion that is known.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { segmentVideo, synthClip } from 'tracecut';
import { sceneMotion } from 'tracecut/stages';

/** Trajectories from lists of places, each with its first frame and label. */
function trajectoriesOf(lists) {
  const offset = [0];
  for (const { places } of lists) offset.push(offset.at(-1) + places.length);
  const all = lists.flatMap(({ places }) => places);
  return {
    count: lists.length,
    startFrame: Uint32Array.from(lists, ({ first }) => first),
    offset: Uint32Array.from(offset),
    x: Float32Array.from(all, ([x]) => x),
    y: Float32Array.from(all, ([, y]) => y),
    label: Uint8Array.from(lists, ({ label }) => label),
  };
}

const line = (first, length, [x, y], [dx, dy], label) => ({
  first,
  label,
  places: Array.from({ length }, (_, t) => [x + t * dx, y + t * dy]),
});

test('the median of the background tells, objects and strangers do not', () => {
  const lists = [
    line(0, 5, [10, 10], [-3, 1], 0),
    line(0, 3, [50, 10], [-3, 1], 0),
    line(2, 3, [60, 20], [-3, 1], 0),
    line(0, 5, [30, 30], [40, 0], 0),
    line(0, 5, [80, 40], [0, 9], 2),
    line(0, 5, [81, 41], [0, 9], 2),
    line(0, 5, [82, 42], [0, 9], 2),
  ];
  const { x, y } = sceneMotion({ numFrames: 5, trajectories: trajectoriesOf(lists) });
  assert.deepEqual([...x], [0, -3, -6, -9, -12]);
  assert.deepEqual([...y], [0, 1, 2, 3, 4]);
});

test('where no background is seen, nothing moves; clusters are taken for their objects', () => {
  const lists = [line(0, 2, [10, 10], [4, 0], 3), line(2, 2, [10, 10], [4, 0], 3), line(0, 4, [0, 0], [50, 50], 1)];
  const { label, ...trajectories } = trajectoriesOf(lists);
  const result = { numFrames: 4, trajectories, clusters: { label, object: [1, 1, 1, 0] } };
  assert.deepEqual([...sceneMotion(result).x], [0, 4, 4, 8]);
  assert.deepEqual([...sceneMotion({ ...result, clusters: { label, object: null } }).x], [0, 0, 0, 0]);
});

test('of a made clip whose camera pans it is the true flow of the background', async () => {
  const clip = await synthClip({ width: 192, height: 108, frames: 8, seed: 0 });
  const frames = Array.from({ length: 8 }, (_, t) => clip.frame(t));
  const { x, y } = sceneMotion(await segmentVideo(frames).collect());
  let [wantedX, wantedY] = [0, 0];
  for (let t = 0; t < 7; t += 1) {
    const [flow, mask] = [clip.flow(t), clip.mask(t)];
    const ground = [...mask.keys()].filter((p) => mask[p] === 0 && p % 7 === 0);
    const middle = (list) => list.sort((a, b) => a - b)[list.length >> 1];
    wantedX += middle(ground.map((p) => flow.u[p]));
    wantedY += middle(ground.map((p) => flow.v[p]));
  }
  assert.ok(Math.abs(wantedX) > 2, `the camera moves by ${wantedX} pixels`);
  assert.ok(Math.abs(x[7] - wantedX) < 1 && Math.abs(y[7] - wantedY) < 1, `${x[7]}, ${y[7]}; ${wantedX}, ${wantedY}`);
  clip.close();
});

test('what has no labels is refused', () => {
  assert.throws(() => sceneMotion(null), { code: 'data', message: /result = null/ });
  assert.throws(() => sceneMotion({ numFrames: 2, trajectories: { count: 0 } }), { code: 'data' });
});
