// The scene: how it moves, what it is without the objects, and objects that look like one thing.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { segmentVideo, synthClip } from 'tracecut';
import { sceneMotion } from 'tracecut/stages';
import { findSimilarObjects } from '../../build/model/join-proposals.js';
import { framesOf, ready, rejects } from '../node/support.mjs';

/** Trajectories from lists of places, each with its first frame and label. */
function trajectoriesOf(lists) {
  const offset = [0];
  for (const { places } of lists) offset.push(offset.at(-1) + places.length);
  const points = lists.flatMap(({ places }) => places);
  return {
    count: lists.length,
    startFrame: Uint32Array.from(lists, ({ first }) => first),
    offset: Uint32Array.from(offset),
    x: Float32Array.from(points, ([x]) => x),
    y: Float32Array.from(points, ([, y]) => y),
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
  const clip = await synthClip({ width: 128, height: 72, frames: 8, seed: 0 });
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

const SCENE = { width: 256, height: 144, frames: 8, seed: 5 };

test('a background has the pixels of the frame where no object is near, and others or holes behind objects', async (t) => {
  const [clip, frames] = [await synthClip(SCENE), await framesOf(SCENE)];
  const session = await ready(t, {}, frames);
  await rejects(session.background(0), 'state', /background of frame 0/);
  const result = await session.run();
  assert.ok(result.objects.length > 0);
  const [frame, labels, plate] = [clip.frame(3).data, result.labels(3), await result.background(3)];
  assert.deepEqual([plate.width, plate.height, plate.scaleX, plate.scaleY], [256, 144, 1, 1]);
  assert.ok(plate.data instanceof Uint8ClampedArray);
  assert.deepEqual(await session.background(3), plate);
  const isNearObject = (p) => {
    for (let y = -2; y <= 2; y += 1) for (let x = -2; x <= 2; x += 1) if (labels[p + 256 * y + x]) return true;
    return false;
  };
  let [numSame, numOther, holes] = [0, 0, 0];
  for (let y = 2; y < 142; y += 1) {
    for (let x = 2; x < 254; x += 1) {
      const p = 256 * y + x;
      const [pixel, original] = [plate.data.subarray(4 * p, 4 * p + 4), frame.subarray(4 * p, 4 * p + 4)];
      if (!isNearObject(p)) {
        assert.deepEqual([...pixel], [...original]);
        numSame += 1;
      } else if (pixel[3] === 0) holes += 1;
      else {
        assert.equal(pixel[3], 255);
        numOther += Number(pixel.some((value, c) => value !== original[c]));
      }
    }
  }
  assert.ok(numSame > 10_000 && numOther > 1000 && holes > 0, `${numSame} ${numOther} ${holes}`);
  await rejects(result.background(8), 'param', /t = 8/);
  session.close();
  await rejects(session.background(0), 'closed');
});

test('the background has the smaller size at which frames are processed', async (t) => {
  const session = await ready(t, { clip: { maxSide: 128 } }, await framesOf(SCENE));
  const { width, height, scaleX, scaleY, data } = await (await session.run()).background(7);
  assert.deepEqual([width, height, scaleX, scaleY, data.length], [128, 72, 2, 2, 4 * 128 * 72]);
});

const [width, height, numFrames] = [96, 64, 12];

/** Boxes `[left, top, width, height]` that move by `[dx, dy]` a frame; the scene moves by `pan`; trajectories end after `trackedFrames`. */
function clipOf(boxes, pan = 0, trackedFrames = numFrames) {
  const at = ({ box, step }, t) => [box[0] + step[0] * t, box[1] + step[1] * t];
  const labels = (t) => {
    const mask = new Uint8Array(width * height);
    boxes.forEach((part, k) => {
      if (part.until !== undefined && t > part.until) return;
      const [x0, y0] = at(part, t).map(Math.round);
      for (let y = y0; y < y0 + part.box[3]; y += 1)
        for (let x = x0; x < x0 + part.box[2]; x += 1)
          if (x >= 0 && y >= 0 && x < width && y < height) mask[y * width + x] = k + 1;
    });
    return mask;
  };
  const tracks = boxes.flatMap((part) => [3, 6].map((offset) => ({ part, offset })));
  const places = tracks.flatMap(({ part, offset }) =>
    Array.from({ length: trackedFrames }, (_, t) => at(part, t).map((v) => v + offset)),
  );
  return {
    ...{ width, height, numFrames, labels },
    trajectories: {
      count: tracks.length,
      startFrame: tracks.map(() => 0),
      offset: Array.from({ length: tracks.length + 1 }, (_, k) => k * trackedFrames),
      x: places.map(([x]) => x),
      y: places.map(([, y]) => y),
    },
    spans: boxes.map(({ until = numFrames - 1 }, k) => ({ object: k + 1, first: 0, last: until })),
    cuts: [],
    scene: { x: Array.from({ length: numFrames }, (_, t) => pan * t), y: new Array(numFrames).fill(0) },
  };
}

const FIRST = { box: [4, 4, 10, 10], step: [2, 0.5] };

const NEXT = { box: [14, 4, 10, 10], step: [2, 0.5] };
const LARGER = { ...NEXT, box: [14, 4, 12, 12] };
const CHAIN = [FIRST, { ...LARGER, step: [2.1, 0.5] }, { box: [27, 4, 8, 8], step: [2, 0.6] }];
const RESTING = [FIRST, NEXT].map((part) => ({ ...part, step: [2, 0] }));

for (const [words, clip, groups] of [
  ['parts that touch and move alike are one group, the largest first; a chain is one group', [CHAIN], [[2, 1, 3]]],
  ['what moves otherwise is none', [[FIRST, { ...LARGER, step: [1, 0.5] }]], []],
  ['what stands apart is none', [[FIRST, { ...NEXT, box: [30, 4, 10, 10] }]], []],
  ['one part alone is none', [[FIRST]], []],
  ['two that move alike in a still scene are one group', [RESTING, 0], [[1, 2]]],
  ['two that rest in the scene say nothing where the camera pans', [RESTING, 2], []],
  ['only frames in which both are there count', [[FIRST, { ...NEXT, until: 3 }]], [[1, 2]]],
  ['a trajectory counts in its own frames only', [[FIRST, NEXT], 0, 8], [[1, 2]]],
])
  test(words, () => assert.deepEqual(findSimilarObjects(clipOf(...clip)), groups));

test('without trajectories nothing is known', () => {
  const { trajectories, ...rest } = clipOf([FIRST, NEXT]);
  assert.deepEqual(findSimilarObjects({ ...rest, trajectories: { ...trajectories, count: 0 } }), []);
});
