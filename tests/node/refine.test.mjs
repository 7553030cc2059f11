// Masks refined, against what is plainly so: specks, soft edges, regions that grow from a place, smoothing along the flow.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { synthClip } from 'tracecut';
import { adjustMask, decodeRuns, growRegions, masksAtSize, smoothMasks } from 'tracecut/edit';
import { createImageEngine } from 'tracecut/stages';
import { plain, rejects } from './support.mjs';

const [WIDTH, HEIGHT] = [37, 23];

/** Labels as a function says. */
const maskOf = (label, width = WIDTH, height = HEIGHT) => ({
  width,
  height,
  labels: Uint8Array.from({ length: width * height }, (_, p) => label(p % width, Math.floor(p / width))),
});

/** Blobs of three labels, some of them specks, the same in each run. */
function blobs(seed) {
  let state = seed;
  const random = (below) => {
    state = (Math.imul(state, 1103515245) + 12345) >>> 0;
    return (state >>> 8) % below;
  };
  const discs = Array.from({ length: 12 }, () => [random(WIDTH), random(HEIGHT), 0.5 + random(5), 1 + random(3)]);
  return maskOf((x, y) => discs.reduce((now, [cx, cy, r, l]) => (Math.hypot(x - cx, y - cy) <= r ? l : now), 0));
}

const distance = (a, b, width) => Math.hypot((a % width) - (b % width), Math.floor(a / width) - Math.floor(b / width));

test('nothing is done where nothing is asked', () => {
  const mask = blobs(3);
  const { labels, alpha, width, height } = adjustMask(mask);
  assert.deepEqual([width, height], [WIDTH, HEIGHT]);
  assert.deepEqual(labels, mask.labels);
  assert.notEqual(labels, mask.labels);
  assert.deepEqual(
    alpha,
    mask.labels.map((label) => (label > 0 ? 255 : 0)),
  );
  const only = adjustMask(mask, { objects: [2] });
  assert.deepEqual(
    only.alpha,
    mask.labels.map((label) => (label === 2 ? 255 : 0)),
  );
});

test('components that are too small become background, other objects stay', () => {
  // A piece of 4 pixels that touch at corners, one of 3, one of 3 of another label.
  const mask = maskOf((x, y) => {
    if (x === y && x < 4) return 1;
    if (y === 10 && x > 20 && x < 24) return 1;
    return y === 15 && x > 20 && x < 24 ? 2 : 0;
  });
  const count = (labels, target) => labels.filter((label) => label === target).length;
  const { labels } = adjustMask(mask, { smallest: 4 });
  assert.deepEqual([count(labels, 1), count(labels, 2)], [4, 0]);
  const adjusted = adjustMask(mask, { smallest: 4, objects: [1] });
  assert.deepEqual([count(adjusted.labels, 1), count(adjusted.labels, 2)], [4, 3]);
  assert.deepEqual(adjustMask(mask, { smallest: 3 }).labels, mask.labels);
});

test('objects grow and shrink by exact distances', () => {
  for (const seed of [1, 2, 5, 9]) {
    const mask = blobs(seed);
    const { labels: before } = mask;
    for (const grow of [1, 1.5, 2.9, 7, -1, -1.5, -3, -40]) {
      const { labels: after } = adjustMask(mask, { grow });
      for (let p = 0; p < before.length; p += 1) {
        const sources = [...before.keys()].filter((q) => (grow > 0 ? before[q] > 0 : before[q] === 0));
        const nearest = Math.min(Infinity, ...sources.map((q) => distance(p, q, WIDTH)));
        const where = `pixel ${p}, seed ${seed}, grow ${grow}`;
        if (grow < 0) assert.equal(after[p], before[p] > 0 && nearest <= -grow ? 0 : before[p], where);
        else if (before[p] > 0) assert.equal(after[p], before[p], where);
        else if (nearest > grow) assert.equal(after[p], 0, where);
        else {
          const labels = sources.filter((q) => distance(p, q, WIDTH) <= nearest + 1e-9).map((q) => before[q]);
          assert.ok(labels.includes(after[p]), where);
        }
      }
    }
  }
});

test('only chosen objects grow, and not over others', () => {
  const mask = maskOf((x) => (x < 5 ? 1 : x < 10 ? 2 : 0));
  const { labels } = adjustMask(mask, { grow: 3, objects: [1] });
  assert.deepEqual(labels, mask.labels);
  assert.equal(adjustMask(mask, { grow: 3, objects: [2] }).labels[12], 2);
  assert.equal(adjustMask(mask, { grow: 3, objects: [2] }).labels[13], 0);
});

test('edges fade within the feather, evenly on both sides, and nowhere else', () => {
  const mask = maskOf((x) => (x < 18 ? 1 : 0));
  for (const feather of [1, 2, 3, 5, 8, 11]) {
    const { alpha, labels } = adjustMask(mask, { feather });
    assert.deepEqual(labels, mask.labels);
    const row = [...alpha.subarray(5 * WIDTH, 6 * WIDTH)];
    row.forEach((value, x) => {
      assert.ok(x === 0 || value <= row[x - 1], `feather ${feather} rises at ${x}`);
      if (x < 18 - feather) assert.equal(value, 255, `feather ${feather} at ${x}`);
      if (x >= 18 + feather) assert.equal(value, 0, `feather ${feather} at ${x}`);
    });
    assert.ok(row[17] > 127 && row[18] < 128 && Math.abs(row[17] + row[18] - 255) <= 4, `${row[17]} ${row[18]}`);
    assert.ok(row[18 + feather - 1] > 0 || feather > 5, `feather ${feather} ends early`);
  }
});

test('values that are not legal are refused', () => {
  const mask = blobs(1);
  const refused = (mask, options, message) => assert.throws(() => adjustMask(mask, options), { message });
  refused(mask, { grow: 101 }, /grow = 101 \(expected a number, -100\.\.=100/);
  refused(mask, { feather: -1 }, /feather = -1 \(expected a number, 0\.\.=100/);
  refused(mask, { smallest: NaN }, /smallest = NaN/);
  refused(mask, { blur: 1 }, /blur = 1 \(expected a known option/);
  refused({ ...mask, width: 3 }, {}, /mask\.labels has 851 labels \(expected 69\)/);
  refused(null, {}, /mask = null/);
});

test('exports at another size grow as much as is seen, and leave specks out', async () => {
  const mask = maskOf((x, y) => (x >= 10 && x < 20 && y >= 8 && y < 16 ? 1 : x === 2 && y === 2 ? 2 : 0));
  const masks = { width: WIDTH, height: HEIGHT, numFrames: 1, labels: () => mask.labels };
  const edges = { smallest: 4, grow: 2 };
  const inside = (x, y) => x >= 30 && x < 60 && y >= 24 && y < 48;
  const picture = plain(3 * WIDTH, 3 * HEIGHT, (x, y) => (inside(x, y) ? 200 : 60));
  const large = await masksAtSize(masks, [picture], { edges });
  const labels = large.labels(0);
  assert.ok(!labels.includes(2));
  const row = [...labels.subarray(3 * 11 * 3 * WIDTH, (3 * 11 + 1) * 3 * WIDTH)];
  assert.deepEqual([row.indexOf(1), row.lastIndexOf(1)], [30 - 6, 59 + 6]);
});

const [DISC_WIDTH, DISC_HEIGHT] = [160, 120];

/** A disc of two colours that moves by three pixels over a textured ground. */
const inDisc = (x, y, shift) => Math.hypot(x - 70 - shift, y - 60) < 28;

function picture(shift) {
  const data = new Uint8Array(4 * DISC_WIDTH * DISC_HEIGHT);
  for (let p = 0; p < DISC_WIDTH * DISC_HEIGHT; p += 1) {
    const [x, y] = [p % DISC_WIDTH, Math.floor(p / DISC_WIDTH)];
    const inside = inDisc(x, y, shift);
    const u = inside ? x - shift : x;
    const texture = ((Math.floor(u / 4) * 7 + Math.floor(y / 4) * 13) % 5) * 9;
    const half = inside && u < 70;
    data.set(inside ? [half ? 190 : 150, 90 + texture, half ? 60 : 130, 255] : [60 + texture, 110, 100, 255], 4 * p);
  }
  return { data, width: DISC_WIDTH, height: DISC_HEIGHT };
}

const truth = Uint8Array.from({ length: DISC_WIDTH * DISC_HEIGHT }, (_, p) =>
  Number(inDisc(p % DISC_WIDTH, Math.floor(p / DISC_WIDTH), 0)),
);

function overlap(a, b) {
  let [both, union] = [0, 0];
  a.forEach((value, p) => ([both, union] = [both + (value & b[p]), union + (value | b[p])]));
  return both / union;
}

let grounds;
before(async () => {
  const engine = await createImageEngine();
  after(() => engine.close());
  const [now, next] = [picture(0), picture(3)];
  grounds = {
    superpixels: await engine.superpixels(now),
    flow: await engine.flow(now, next),
    picture: now,
  };
});

test('a click on a part of what moves gives the whole of it first', async () => {
  for (const place of [
    { x: 60, y: 60 },
    { x: 84, y: 70 },
  ]) {
    const [first] = await growRegions(grounds, place);
    const similarity = overlap(decodeRuns(first), truth);
    assert.ok(similarity > 0.85, `${similarity.toFixed(2)} at ${place.x}, ${place.y}`);
    const { label } = grounds.superpixels;
    const piece = label.map((value) => Number(value === label[place.y * DISC_WIDTH + place.x]));
    assert.ok(overlap(piece, truth) < 0.6, 'one superpixel is less');
  }
});

test('regions hold the place, differ in size, and are the same each time', async () => {
  const place = { x: 60.4, y: 59.6 };
  const regions = await growRegions(grounds, place);
  assert.ok(regions.length >= 2 && regions.length <= 3, `${regions.length} regions`);
  const areas = regions.map((region) => decodeRuns(region).reduce((sum, value) => sum + value, 0));
  for (const [k, region] of regions.entries()) {
    assert.equal(decodeRuns(region)[60 * DISC_WIDTH + 60], 1);
    for (const smallerArea of areas.slice(0, k))
      assert.ok(Math.min(smallerArea, areas[k]) < 0.7 * Math.max(smallerArea, areas[k]), areas.join(' '));
  }
  assert.deepEqual(await growRegions(grounds, place), regions);
});

test('errors name the wrong value', async () => {
  const rejects = (input, place, message) => assert.rejects(growRegions(input, place), message);
  await rejects(grounds, { x: 160, y: 3 }, /x = 160 \(expected .*0\.\.=159/);
  await rejects({ ...grounds, flow: { ...grounds.flow, width: 80 } }, { x: 1, y: 1 }, /flow = .*80 × 120.*160 × 120/);
  await rejects({ ...grounds, picture: { ...grounds.picture, data: new Uint8Array(4) } }, { x: 1, y: 1 }, /4 bytes/);
});

const [SQUARE_WIDTH, SQUARE_HEIGHT, FRAMES] = [96, 64, 7];
/** Pixels that the square moves in a frame: more than its side, so that it never covers itself. */
const STEP = 12;
const SIDE = 8;

/** A square that leaps to the right, and the flow that says so: nobody has to find it. */
const squareAt = (t) => (p) => {
  const [x, y] = [(p % SQUARE_WIDTH) - STEP * t, Math.floor(p / SQUARE_WIDTH)];
  return x >= 0 && x < SIDE && y >= 20 && y < 20 + SIDE;
};
const squareMask = (t) => Uint8Array.from({ length: SQUARE_WIDTH * SQUARE_HEIGHT }, (_, p) => (squareAt(t)(p) ? 3 : 0));
const pictureOf = (t) => ({
  width: SQUARE_WIDTH,
  height: SQUARE_HEIGHT,
  data: new Uint8Array(4 * SQUARE_WIDTH * SQUARE_HEIGHT).fill(t),
  t,
});
const engine = {
  async flow(from, to) {
    const u = Float32Array.from({ length: SQUARE_WIDTH * SQUARE_HEIGHT }, (_, p) =>
      squareAt(from.t)(p) ? STEP * (to.t - from.t) : 0,
    );
    return { width: SQUARE_WIDTH, height: SQUARE_HEIGHT, u, v: new Float32Array(u.length) };
  },
};
const masksOf = (change, more = {}) => ({
  width: SQUARE_WIDTH,
  height: SQUARE_HEIGHT,
  numFrames: FRAMES,
  labels: (t) => change(squareMask(t), t),
  ...more,
});
const smoothed = (masks, options) => smoothMasks(masks, { picture: pictureOf, engine, ...options });
const area = (labels) => labels.filter((label) => label > 0).length;

test('what moves farther than it is wide stays as it is', async () => {
  const result = await smoothed(masksOf((labels) => labels));
  for (let t = 0; t < FRAMES; t += 1) assert.deepEqual(result.labels(t), squareMask(t), `frame ${t}`);
  assert.deepEqual([result.width, result.height, result.numFrames], [SQUARE_WIDTH, SQUARE_HEIGHT, FRAMES]);
});

test('regions in only one frame are removed, regions missing in one are added', async () => {
  const masks = masksOf((labels, t) => {
    if (t === 3) labels.fill(0);
    if (t === 2) labels.fill(5, 40 * SQUARE_WIDTH, 40 * SQUARE_WIDTH + 20);
    return labels;
  });
  const result = await smoothed(masks);
  for (const t of [1, 2, 4, 5]) assert.deepEqual(result.labels(t), squareMask(t), `frame ${t}`);
  // Of frame 3 the flow says nothing about pixels that are no longer on the square, but those on it come back.
  assert.deepEqual(result.labels(3), squareMask(3));
});

test('two frames that are wrong need a longer reach', async () => {
  const masks = masksOf((labels, t) => (t === 3 || t === 4 ? labels.fill(0) : labels));
  assert.equal(area((await smoothed(masks)).labels(3)), 0);
  assert.equal(area((await smoothed(masks, { reach: 2 })).labels(3)), SIDE * SIDE);
});

test('beyond a cut nobody has a vote, and without reach nothing changes', async () => {
  const withoutFrame3 = (labels, t) => (t === 3 ? labels.fill(0) : labels);
  const shots = [
    { first: 0, last: 3 },
    { first: 4, last: FRAMES - 1 },
  ];
  const cut = await smoothed(masksOf(withoutFrame3, { shots, times: [0, 1, 2, 3, 4, 5, 6], end: 8 }));
  assert.equal(area(cut.labels(3)), 0);
  assert.deepEqual([cut.shots, [...cut.times], cut.end], [shots, [0, 1, 2, 3, 4, 5, 6], 8]);
  assert.equal(area((await smoothed(masksOf(withoutFrame3), { reach: 0 })).labels(3)), 0);
});

test('frames come from the wanted one on, each flow is asked for once, and an abort ends it', async () => {
  const requestedFrames = [];
  const counting = {
    flow(from, to) {
      requestedFrames.push(`${from.t}-${to.t}`);
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
  assert.ok(requestedFrames.length - new Set(requestedFrames).size <= 4, String(requestedFrames));
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
  const imageEngine = await createImageEngine();
  const result = await smoothMasks(masks, { picture: (t) => clip.frame(t), engine: imageEngine });
  const truth = clip.mask(3);
  const correctPixels = result.labels(3).filter((label, p) => label === 1 && truth[p] === 1).length;
  const objectPixels = truth.filter((label) => label === 1).length;
  assert.ok(correctPixels > 0.8 * objectPixels, `${correctPixels} of ${objectPixels} pixels`);
  // The engine stays open: it is the caller's.
  await imageEngine.flow(clip.frame(0), clip.frame(1));
  imageEngine.close();
  const expected = await smoothMasks(masks, { picture: (t) => clip.frame(t) });
  assert.deepEqual(expected.labels(3), result.labels(3));
  clip.close();
});

test('values that are not legal are refused', async () => {
  const masks = masksOf((labels) => labels);
  await rejects(smoothMasks(masks, {}), 'param', /^picture = undefined/);
  await rejects(smoothed(masks, { reach: 5 }), 'param', /reach = 5 \(expected .*0\.\.=?4/);
  await rejects(smoothed(masks, { first: 7 }), 'param', /first = 7/);
  await rejects(smoothed(masks, { picture: () => null }), 'data', /picture\(0\)/);
  await rejects(smoothed(null), 'data', /masks = null/);
});
