// Masks without a session, against what is plainly so: adjusted, grown from a place, smoothed along the flow, and enlarged to the size of
// the source.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { maskPng, masksZip, synthClip } from 'tracecut';
import { adjustMask, decodeRuns, enlargeMask, growRegions, masksAtSize, smoothMasks } from 'tracecut/edit';
import { estimateVideoSize, soundInfo } from 'tracecut/export';
import { createImageEngine } from 'tracecut/stages';
import { RemoteEngine } from '../../dist/worker/remote.js';
import { wav } from '../browser/page-helpers.mjs';
import { abortAt, compileWasm, fnv1a, mapPixels, overlapOf, plain, png, rejects, standIn } from './support.mjs';

const [WIDTH, HEIGHT] = [37, 23];

/** Labels as a function says. */
const maskOf = (label, width = WIDTH, height = HEIGHT) => ({
  width,
  height,
  labels: mapPixels(width, height, label),
});

/** Returns the opacity of a mask with hard edges. */
const opacityOf = ({ labels }, isOpaque = (label) => label > 0) => labels.map((label) => 255 * isOpaque(label));

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
  assert.deepEqual(alpha, opacityOf(mask));
  const opacity = opacityOf(mask, (label) => label === 2);
  assert.deepEqual(adjustMask(mask, { objects: [2] }).alpha, opacity);
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
  for (const seed of [1, 5]) {
    const mask = blobs(seed);
    const { labels: before } = mask;
    for (const grow of [1, 1.5, 2.9, 7, -1, -1.5, -3, -40]) {
      const { labels: after } = adjustMask(mask, { grow });
      const sources = [...before.keys()].filter((q) => (grow > 0 ? before[q] > 0 : before[q] === 0));
      for (let p = 0; p < before.length; p += 1) {
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

const truth = mapPixels(DISC_WIDTH, DISC_HEIGHT, (x, y) => inDisc(x, y, 0));

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
    const similarity = overlapOf(decodeRuns(first), truth);
    assert.ok(similarity > 0.85, `${similarity.toFixed(2)} at ${place.x}, ${place.y}`);
    const { label } = grounds.superpixels;
    const piece = label.map((value) => Number(value === label[place.y * DISC_WIDTH + place.x]));
    assert.ok(overlapOf(piece, truth) < 0.6, 'one superpixel is less');
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
  const unchanged = masksOf((labels) => labels);
  const onFrame = ({ t, labels, masks }) => {
    order.push(t);
    assert.deepEqual(masks.labels(t), labels);
  };
  await smoothed(unchanged, { engine: counting, reach: 2, first: 4, onFrame });
  assert.deepEqual(order, [4, 5, 6, 0, 1, 2, 3]);
  // The second half meets flow of the first, long forgotten.
  assert.ok(requestedFrames.length - new Set(requestedFrames).size <= 4, String(requestedFrames));
  const stop = abortAt({ reason: new Error('enough'), callback: 'onFrame' });
  await assert.rejects(smoothed(unchanged, stop), /enough/);
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

/** Three frames of 4 x 2 pixels with an object that moves to the right. */
const masks = {
  width: 4,
  height: 2,
  numFrames: 3,
  times: [0.5, 0.54, 0.7],
  shots: [{ first: 0, last: 2 }],
  labels: (t) => Uint8Array.from({ length: 8 }, (_, p) => (p % 4 === t ? 3 : 0)),
};

test('masks are enlarged to the size of their frames, with their times, and can be saved', async () => {
  const progress = [];
  const large = await masksAtSize(masks, [plain(12, 8), { frame: plain(12, 8) }, plain(12, 8), plain(1, 1)], {
    onProgress: (step) => progress.push(`${step.done}/${step.total}`),
  });
  assert.deepEqual([large.width, large.height, large.numFrames], [12, 8, 3]);
  assert.deepEqual([...large.times], masks.times);
  assert.deepEqual(large.shots, masks.shots);
  assert.deepEqual(progress, ['1/3', '2/3', '3/3']);
  for (let t = 0; t < 3; t += 1) {
    const labels = large.labels(t);
    for (let p = 0; p < 96; p += 1) assert.equal(labels[p], Math.floor((p % 12) / 3) === t ? 3 : 0, `pixel ${p}`);
  }
  const png = await maskPng(large, 1);
  assert.deepEqual([...png.subarray(16, 24)], [0, 0, 0, 12, 0, 0, 0, 8]);
  assert.ok((await masksZip(large)).length > 3 * png.length);
});

test('masks of the frames’ size stay as they are', async () => {
  const unscaled = await masksAtSize(masks, [plain(4, 2), plain(4, 2), plain(4, 2)]);
  for (let t = 0; t < 3; t += 1) assert.deepEqual(unscaled.labels(t), masks.labels(t));
});

test('frames of another shape than the masks stretch them, pixel by pixel', async () => {
  const wide = { width: 400, height: 200, numFrames: 1, labels: () => new Uint8Array(80000).fill(1, 20000, 50100) };
  const large = await masksAtSize(wide, [plain(800, 407)]);
  const labels = large.labels(0);
  for (let y = 0; y < 407; y += 1)
    for (let x = 0; x < 800; x += 7) {
      const p = 400 * Math.floor(((y + 0.5) * 200) / 407) + Math.floor(x / 2);
      assert.equal(labels[800 * y + x], Number(p >= 20000 && p < 50100), `${x}, ${y}`);
    }
});

test('frames that are too few, of another size, or no pixels are refused', async () => {
  await rejects(masksAtSize(masks, [plain(8, 4)]), 'data', /ended after 1 of 3/);
  await rejects(
    masksAtSize(masks, [plain(8, 4), plain(8, 6)]),
    'frame-size-changed',
    /frame 1 is 8 × 6 pixels \(expected 8 × 4/,
  );
  await rejects(masksAtSize(masks, [7, 7, 7]), 'data', /frame 0 = 7 \(expected/);
  await rejects(masksAtSize({ ...masks, width: 0 }, []), 'data', /masks\.width = 0/);
  await rejects(masksAtSize(masks, [], { size: 4 }), 'param', /size = 4 \(expected a known option/);
  const stopped = AbortSignal.abort();
  await assert.rejects(masksAtSize(masks, [plain(8, 4)], { signal: stopped }), { name: 'AbortError' });
});

test('a finer video, a larger one and a longer one is larger', () => {
  const clip = { width: 854, height: 480, numFrames: 100 };
  const sizes = ['low', 'medium', 'high', 'very-high'].map((quality) => estimateVideoSize({ ...clip, quality }));
  const ascending = [...sizes].sort((a, b) => a - b);
  assert.deepEqual(sizes, ascending);
  assert.equal(estimateVideoSize(clip), sizes[2]);
  assert.equal(estimateVideoSize({ ...clip, numFrames: 200 }), 2 * sizes[2]);
  assert.ok(estimateVideoSize({ ...clip, style: 'cutout' }) < sizes[2]);
  const refused = (video, message) => assert.throws(() => estimateVideoSize(video), { code: 'param', message });
  refused({ ...clip, quality: 'best' }, /quality = "best" \(expected 'low', /);
  refused({ ...clip, width: 0 }, /width = 0/);
  refused({ ...clip, style: 'green' }, /style = "green"/);
});

test('the sound of a file, and which videos can hold it', async () => {
  const bytes = wav(new Int16Array(4000));
  const expected = { codec: 'pcm-s16', channels: 1, sampleRate: 8000, formats: ['mp4'], converted: [] };
  assert.deepEqual(await soundInfo(new Blob([bytes])), expected);
  assert.deepEqual(await soundInfo(new Uint8Array(bytes)), expected);
  assert.equal(await soundInfo(new Blob(['no file of sound at all'])), null);
});

const [LARGE_WIDTH, LARGE_HEIGHT] = [160, 96];
const [RADIUS, SOFT] = [30, 6];

/** Coverage of a pixel by a disc with a soft border, 0 to 1. */
const share = (x, y) => Math.min(1, Math.max(0, 0.5 + (RADIUS - Math.hypot(x - 79.3, y - 47.8)) / SOFT));
/** A bright disc on a dark background, both with some texture. */
const disc = () => plain(LARGE_WIDTH, LARGE_HEIGHT, (x, y) => 60 + 110 * share(x, y) + ((x * 7 + y * 13) % 9));
/** Its mask at a part of the size; the disc has this label. */
function discMask(isInside, label = 1) {
  const [width, height] = [LARGE_WIDTH / isInside, LARGE_HEIGHT / isInside];
  const centre = (place) => place * isInside + isInside / 2 - 0.5;
  const labels = mapPixels(width, height, (x, y) => label * (share(centre(x), centre(y)) >= 0.5));
  return { width, height, labels };
}
const coverage = Float64Array.from({ length: LARGE_WIDTH * LARGE_HEIGHT }, (_, p) =>
  share(p % LARGE_WIDTH, Math.floor(p / LARGE_WIDTH)),
);
const wrong = (labels) => labels.reduce((sum, label, p) => sum + Number(label > 0 !== coverage[p] >= 0.5), 0);

test('a mask of a quarter of the size comes to the border of its picture, and is as soft', async () => {
  const mask = discMask(4);
  const originalLabels = mask.labels.slice();
  const { width, height, labels, alpha } = await enlargeMask(mask, disc());
  assert.deepEqual([width, height], [LARGE_WIDTH, LARGE_HEIGHT]);
  assert.deepEqual([labels.length, alpha.length], Array(2).fill(width * height));
  const nearest = labels.map(
    (_, p) => originalLabels[(Math.floor(p / LARGE_WIDTH) >> 2) * mask.width + ((p % LARGE_WIDTH) >> 2)],
  );
  assert.ok(2 * wrong(labels) < wrong(nearest), `${wrong(labels)} wrong, ${wrong(nearest)} of the nearest`);
  const error = (values) => values.reduce((sum, value, p) => sum + Math.abs(value - coverage[p]), 0);
  const [soft, hard] = [error(Float64Array.from(alpha, (a) => a / 255)), error(Float64Array.from(labels))];
  assert.ok(soft < 0.8 * hard, `off by ${soft} in all, ${hard} without opacity`);
  alpha.forEach((a, p) => assert.equal(a >= 128, labels[p] > 0));
  assert.deepEqual(mask.labels, originalLabels);
});

test('files, pixels and a worker give the same bytes as every machine', async (t) => {
  const mask = discMask(2);
  const large = await enlargeMask(mask, disc());
  assert.deepEqual(await enlargeMask(mask, png(disc())), large);
  assert.deepEqual(await enlargeMask(mask, new Blob([png(disc())])), large);
  const worker = standIn();
  t.after(() => worker.terminate());
  const engine = new RemoteEngine(worker);
  const module = await compileWasm('decoder');
  const task = () => ({
    labels: mask.labels.slice(),
    width: mask.width,
    picture: { ...disc(), data: new Uint8Array(disc().data), kind: 'pixels' },
    chosen: new Uint8Array(256).fill(1, 1),
    module,
  });
  const enlarged = (data) => engine.send({ type: 'enlarge', data });
  assert.deepEqual(await enlarged(task()), large);
  await rejects(enlarged({ ...task(), width: 40 }), 'param', /mask = 40x96/);
  assert.deepEqual(await enlarged(task()), large);
  assert.deepEqual([fnv1a(large.labels), fnv1a(large.alpha)], FINGERPRINT);
});

/** Of labels and opacity. */
const FINGERPRINT = ['2d229a87', '506ee80f'];

test('only the objects asked for are opaque', async () => {
  const mask = discMask(2, 3);
  const allObjects = await enlargeMask(mask, disc());
  assert.deepEqual(await enlargeMask(mask, disc(), { objects: [3, 9] }), allObjects);
  assert.deepEqual(await enlargeMask(mask, disc(), { objects: (label) => label === 3 }), allObjects);
  const noObject = await enlargeMask(mask, disc(), { objects: [9] });
  assert.deepEqual(noObject.labels, allObjects.labels);
  assert.ok(noObject.alpha.every((a) => a === 0));
  const ground = await enlargeMask(mask, disc(), { objects: [0] });
  ground.alpha.forEach((a, p) =>
    assert.ok(Math.abs(a + allObjects.alpha[p] - 255) <= 1, `${a} and ${allObjects.alpha[p]} at ${p}`),
  );
});

test('a mask of the size of its picture keeps its labels; a flat picture moves nothing', async () => {
  const mask = discMask(1);
  assert.deepEqual((await enlargeMask(mask, disc())).labels, mask.labels);
  const flat = await enlargeMask(mask, plain(LARGE_WIDTH, LARGE_HEIGHT, 90));
  assert.deepEqual(flat.labels, mask.labels);
  assert.deepEqual(flat.alpha, opacityOf(mask));
});

test('what cannot be used is refused', async () => {
  const mask = discMask(2);
  const enlargeWith = (part) => enlargeMask({ ...mask, ...part }, disc());
  await rejects(enlargeMask(null, disc()), 'data', /mask = null \(expected an object \{labels, width, height\}\)/);
  await rejects(enlargeWith({ width: 0 }), 'data', /mask\.width = 0 \(expected a whole number, 1\.\.=16384\)/);
  await rejects(enlargeWith({ labels: [1, 2] }), 'data', /mask\.labels = a list of 2 \(expected a Uint8Array/);
  await rejects(enlargeWith({ labels: new Uint8Array(3) }), 'data', /has 3 labels \(expected 3840\)/);
  await rejects(enlargeMask(mask, 'frame.png'), 'data', /frame = "frame\.png"/);
  await rejects(enlargeMask(mask, new Uint8Array(9)), 'decode');
  await rejects(
    enlargeMask(mask, plain(70, 42)),
    'param',
    /mask = 80x48 \(expected at most the picture's size, 70x42\)/,
  );
  await rejects(enlargeMask(mask, plain(160, 120)), 'param', /mask = 80x48 \(expected the shape .* 160x120\)/);
  await rejects(enlargeMask(mask, disc(), { objects: [256] }), 'param', /objects = 256 \(expected .* 0\.\.=255\)/);
  await rejects(enlargeMask(mask, disc(), { objects: 3 }), 'param', /objects = 3/);
  await rejects(enlargeMask(mask, disc(), { alpha: true }), 'param', /alpha = true/);
  // Nothing of this is left behind.
  assert.equal((await enlargeMask(mask, disc())).width, LARGE_WIDTH);
});
