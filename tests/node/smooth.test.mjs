// Masks smoothed over time along the flow, against what is plainly so.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { synthClip } from 'tracecut';
import { smoothMasks } from 'tracecut/edit';
import { createImageEngine } from 'tracecut/stages';
import { rejects } from './support.mjs';

const [WIDTH, HEIGHT, FRAMES] = [96, 64, 7];
/** Pixels that the square moves in a frame: more than its side, so that it never covers itself. */
const STEP = 12;
const SIDE = 8;

/** A square that leaps to the right, and the flow that says so: nobody has to find it. */
const squareAt = (t) => (p) => {
  const [x, y] = [(p % WIDTH) - STEP * t, Math.floor(p / WIDTH)];
  return x >= 0 && x < SIDE && y >= 20 && y < 20 + SIDE;
};
const maskOf = (t) => Uint8Array.from({ length: WIDTH * HEIGHT }, (_, p) => (squareAt(t)(p) ? 3 : 0));
const pictureOf = (t) => ({ width: WIDTH, height: HEIGHT, data: new Uint8Array(4 * WIDTH * HEIGHT).fill(t), t });
const engine = {
  async flow(from, to) {
    const u = Float32Array.from({ length: WIDTH * HEIGHT }, (_, p) =>
      squareAt(from.t)(p) ? STEP * (to.t - from.t) : 0,
    );
    return { width: WIDTH, height: HEIGHT, u, v: new Float32Array(u.length) };
  },
};
const masksOf = (change, more = {}) => ({
  width: WIDTH,
  height: HEIGHT,
  numFrames: FRAMES,
  labels: (t) => change(maskOf(t), t),
  ...more,
});
const smoothed = (masks, options) => smoothMasks(masks, { picture: pictureOf, engine, ...options });
const area = (labels) => labels.filter((label) => label > 0).length;

test('what moves farther than it is wide stays as it is', async () => {
  const result = await smoothed(masksOf((labels) => labels));
  for (let t = 0; t < FRAMES; t += 1) assert.deepEqual(result.labels(t), maskOf(t), `frame ${t}`);
  assert.deepEqual([result.width, result.height, result.numFrames], [WIDTH, HEIGHT, FRAMES]);
});

test('what is in one frame alone goes, what is missing in one comes', async () => {
  const masks = masksOf((labels, t) => {
    if (t === 3) labels.fill(0);
    if (t === 2) labels.fill(5, 40 * WIDTH, 40 * WIDTH + 20);
    return labels;
  });
  const result = await smoothed(masks);
  for (const t of [1, 2, 4, 5]) assert.deepEqual(result.labels(t), maskOf(t), `frame ${t}`);
  // Of frame 3 the flow says nothing about pixels that are no longer on the square, but those on it come back.
  assert.deepEqual(result.labels(3), maskOf(3));
});

test('two frames that are wrong need a longer reach', async () => {
  const masks = masksOf((labels, t) => (t === 3 || t === 4 ? labels.fill(0) : labels));
  assert.equal(area((await smoothed(masks)).labels(3)), 0);
  assert.equal(area((await smoothed(masks, { reach: 2 })).labels(3)), SIDE * SIDE);
});

test('beyond a cut nobody has a vote, and without reach nothing changes', async () => {
  const lost = (labels, t) => (t === 3 ? labels.fill(0) : labels);
  const shots = [
    { first: 0, last: 3 },
    { first: 4, last: FRAMES - 1 },
  ];
  const cut = await smoothed(masksOf(lost, { shots, times: [0, 1, 2, 3, 4, 5, 6], end: 8 }));
  assert.equal(area(cut.labels(3)), 0);
  assert.deepEqual([cut.shots, [...cut.times], cut.end], [shots, [0, 1, 2, 3, 4, 5, 6], 8]);
  assert.equal(area((await smoothed(masksOf(lost), { reach: 0 })).labels(3)), 0);
});

test('frames come from the wanted one on, each flow is asked for once, and an abort ends it', async () => {
  const asked = [];
  const counting = {
    flow(from, to) {
      asked.push(`${from.t}-${to.t}`);
      return engine.flow(from, to);
    },
  };
  const order = [];
  await smoothed(
    masksOf((labels) => labels),
    {
      ...{ engine: counting, reach: 2, first: 4 },
      onFrame: ({ t, labels, masks }) => {
        order.push([t, area(labels)]);
        assert.deepEqual(masks.labels(t), labels);
      },
    },
  );
  assert.deepEqual(
    order.map(([t]) => t),
    [4, 5, 6, 0, 1, 2, 3],
  );
  // The second half meets flow of the first, long forgotten.
  assert.ok(asked.length - new Set(asked).size <= 4, String(asked));
  const stop = new AbortController();
  const stopped = smoothed(
    masksOf((labels) => labels),
    { signal: stop.signal, onFrame: () => stop.abort(new Error('enough')) },
  );
  await assert.rejects(stopped, /enough/);
});

test('with flow of real pictures a hole in one frame of a moving object closes', async () => {
  const clip = await synthClip({ width: 160, height: 90, frames: 6, seed: 1 });
  const hole = (t) => clip.mask(t).map((label) => (t === 3 && label === 1 ? 0 : label));
  const masks = { width: 160, height: 90, numFrames: 6, labels: hole };
  const own = await createImageEngine();
  const result = await smoothMasks(masks, { picture: (t) => clip.frame(t), engine: own });
  const truth = clip.mask(3);
  const found = result.labels(3).filter((label, p) => label === 1 && truth[p] === 1).length;
  const all = truth.filter((label) => label === 1).length;
  assert.ok(found > 0.8 * all, `${found} of ${all} pixels`);
  // The engine stays open: it is the caller's.
  await own.flow(clip.frame(0), clip.frame(1));
  own.close();
  const alone = await smoothMasks(masks, { picture: (t) => clip.frame(t) });
  assert.deepEqual(alone.labels(3), result.labels(3));
  clip.close();
});

test('values that are not legal are refused', async () => {
  const masks = masksOf((labels) => labels);
  await rejects(smoothMasks(masks, {}), 'param', /options\.picture/);
  await rejects(smoothed(masks, { reach: 5 }), 'param', /reach = 5 \(expected .*0\.\.=?4/);
  await rejects(smoothed(masks, { first: 7 }), 'param', /first = 7/);
  await rejects(smoothed(masks, { picture: () => null }), 'data', /picture\(0\)/);
  await rejects(smoothed(null), 'data', /masks = null/);
});
