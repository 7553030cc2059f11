// PNG files of cut-out objects: in an archive, as an animation, and read again by nothing but their format.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { trailFrames } from 'tracecut/draw';
import { encodeImages } from 'tracecut/export';
import { unzipSync, unzlibSync } from '../../dist/vendor/zip.js';
import { pngParts } from '../png.mjs';
import { rejects } from './support.mjs';

const [WIDTH, HEIGHT] = [9, 7];
const inside = (t, x, y) => x >= 2 + t && x < 5 + t && y >= 2 && y < 5;
const masks = {
  width: WIDTH,
  height: HEIGHT,
  numFrames: 3,
  times: [1, 1.25, 1.3],
  end: 2,
  labels: (t) =>
    Uint8Array.from({ length: WIDTH * HEIGHT }, (_, p) => Number(inside(t, p % WIDTH, Math.floor(p / WIDTH)))),
};
const frameOf = (t, width = WIDTH, height = HEIGHT) => {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1)
    data.set([(7 * (p % width)) % 256, (9 * Math.floor(p / width)) % 256, 50 * t, 255], 4 * p);
  return { data, width, height };
};
const frames = () => [0, 1, 2].map((t) => frameOf(t));

async function bytesOf(options, from = masks, of = frames()) {
  return new Uint8Array(await new Response(await encodeImages(from, of, options)).arrayBuffer());
}

/** Pixels of deflated rows, by the definition of all five filters. */
function pixelsOf(data, channels) {
  const raw = unzlibSync(data);
  const size = WIDTH * channels;
  const pixels = new Uint8Array(HEIGHT * size);
  for (let y = 0; y < HEIGHT; y += 1) {
    const filter = raw[y * (size + 1)];
    for (let k = 0; k < size; k += 1) {
      const left = k < channels ? 0 : pixels[y * size + k - channels];
      const up = y > 0 ? pixels[(y - 1) * size + k] : 0;
      assert.ok([0, 1, 2, 3].includes(filter), `filter ${filter}`);
      const guess = [0, left, up, (left + up) >> 1][filter];
      pixels[y * size + k] = raw[y * (size + 1) + 1 + k] + guess;
    }
  }
  return pixels;
}

const wanted = (t) => {
  const { data } = frameOf(t);
  return Uint8Array.from({ length: 4 * WIDTH * HEIGHT }, (_, k) => {
    const p = k >> 2;
    if (!inside(t, p % WIDTH, Math.floor(p / WIDTH))) return 0;
    return k % 4 === 3 ? 255 : data[k];
  });
};

test('an archive holds the objects of each frame on nothing, and the times', async () => {
  const bytes = await bytesOf({});
  const files = unzipSync(bytes);
  assert.deepEqual(Object.keys(files), ['00000.png', '00001.png', '00002.png', 'images.json']);
  for (const t of [0, 1, 2]) {
    const chunks = pngParts(files[`0000${t}.png`]);
    assert.deepEqual(
      chunks.map(({ type }) => type),
      ['IHDR', 'IDAT', 'IEND'],
    );
    assert.deepEqual([...chunks[0].data], [0, 0, 0, WIDTH, 0, 0, 0, HEIGHT, 8, 6, 0, 0, 0]);
    assert.deepEqual(pixelsOf(chunks[1].data, 4), wanted(t), `frame ${t}`);
  }
  const about = JSON.parse(new TextDecoder().decode(files['images.json']));
  assert.deepEqual([about.times, about.end, about.width, about.files[2]], [masks.times, 2, WIDTH, '00002.png']);
  assert.deepEqual(await bytesOf({}), bytes);
});

test('an animation has the frames’ durations, that of the last too', async () => {
  const chunks = pngParts(await bytesOf({ format: 'apng' }));
  assert.deepEqual(
    chunks.map(({ type }) => type),
    ['IHDR', 'acTL', 'fcTL', 'IDAT', 'fcTL', 'fdAT', 'fcTL', 'fdAT', 'IEND'],
  );
  const numbers = (data, ...at) => at.map((k) => new DataView(data.buffer).getUint32(k));
  assert.deepEqual(numbers(chunks[1].data, 0, 4), [3, 0]);
  const heads = chunks.filter(({ type }) => type === 'fcTL').map(({ data }) => data);
  const delays = heads.map(({ buffer }) => new DataView(buffer).getUint16(20) / new DataView(buffer).getUint16(22));
  assert.deepEqual(delays, [0.25, 0.05, 0.7]);
  const counted = chunks.filter(({ type }) => ['fcTL', 'fdAT'].includes(type)).map(({ data }) => numbers(data, 0)[0]);
  assert.deepEqual(counted, [0, 1, 2, 3, 4]);
  assert.deepEqual(pixelsOf(chunks[3].data, 4), wanted(0));
  assert.deepEqual(pixelsOf(chunks[7].data.slice(4), 4), wanted(2));
});

test('opacity alone is grey, soft where edges are', async () => {
  const grey = async (edges) => {
    const [head, data] = pngParts(unzipSync(await bytesOf({ style: 'alpha', edges }))['00000.png']);
    assert.equal(head.data[9], 0);
    return pixelsOf(data.data, 1);
  };
  assert.deepEqual(
    await grey({}),
    masks.labels(0).map((label) => 255 * label),
  );
  const soft = await grey({ feather: 2 });
  assert.ok(
    soft.some((value) => value > 0 && value < 255),
    String(soft),
  );
});

test('objects that are not meant are left out; masks that are smaller are enlarged', async () => {
  const other = { ...masks, labels: (t) => masks.labels(t).map((label, p) => (p === 0 ? 2 : label)) };
  const alphaOf = async (objects) => {
    const files = unzipSync(await bytesOf({ objects, style: 'alpha' }, other));
    return pixelsOf(pngParts(files['00001.png'])[1].data, 1);
  };
  assert.equal((await alphaOf([1]))[0], 0);
  assert.equal((await alphaOf([2]))[0], 255);
  const large = [0, 1, 2].map((t) => frameOf(t, 3 * WIDTH, 3 * HEIGHT));
  const [head] = pngParts(unzipSync(await bytesOf({}, masks, large))['00002.png']);
  assert.deepEqual([head.data[3], head.data[7]], [3 * WIDTH, 3 * HEIGHT]);
});

test('a frame is asked for when it is read, not before; who stops reading ends it', async () => {
  let given = 0;
  let ended = false;
  async function* slow() {
    try {
      for (let t = 0; t < 3; t += 1) {
        given += 1;
        yield frameOf(t);
      }
    } finally {
      ended = true;
    }
  }
  const reader = (await encodeImages(masks, slow(), { format: 'apng' })).getReader();
  await new Promise((done) => setTimeout(done, 20));
  assert.equal(given, 0);
  await reader.read();
  assert.equal(given, 1);
  await reader.cancel();
  assert.deepEqual([given, ended], [1, true]);
});

test('what is not legal is refused, and an abort is told', async () => {
  await rejects(encodeImages(masks, frames(), { format: 'gif' }), 'param', /format = "gif" \(expected 'zip', 'apng'/);
  await rejects(encodeImages(masks, frames(), { style: 'overlay' }), 'param', /style = "overlay"/);
  await rejects(encodeImages(masks, null), 'param', /frames = null/);
  await rejects(encodeImages({ ...masks, end: 1 }, frames()), 'data', /masks\.end = 1/);
  await rejects(bytesOf({}, masks, frames().slice(1)), 'data', /ended after 2 of 3/);
  const stop = new AbortController();
  const reading = bytesOf({ signal: stop.signal, onProgress: () => stop.abort(new Error('enough')) });
  await assert.rejects(reading, /enough/);
});

describe('a trail', () => {
  /** A clip of one row in which an object of one pixel goes one to the right each frame; frame `t` is of the colour `t`. */
  const count = 12;
  const clip = {
    width: WIDTH,
    height: HEIGHT,
    numFrames: count,
    labels: (t) => Uint8Array.from({ length: WIDTH * HEIGHT }, (_, p) => Number(p === WIDTH * 3 + (t % WIDTH))),
  };
  const colour = (t) => [10 + 20 * t, 250 - 20 * t, 7];
  const pictures = Array.from({ length: count }, (_, t) => {
    const data = new Uint8ClampedArray(4 * WIDTH * HEIGHT);
    for (let p = 0; p < WIDTH * HEIGHT; p += 1) data.set([...colour(t), 255], 4 * p);
    return { data, width: WIDTH, height: HEIGHT };
  });
  /** Pixels of frame `t` that are not clear, by their column. */
  const seen = async (t, options, masks_ = clip) => {
    const files = unzipSync(await bytesOf(options, masks_, pictures));
    const pixels = pixelsOf(pngParts(files[`${String(t).padStart(5, '0')}.png`])[1].data, 4);
    const there = Array.from({ length: WIDTH * HEIGHT }, (_, p) => [p, ...pixels.subarray(4 * p, 4 * p + 4)]);
    return there.filter((pixel) => pixel[4] > 0).map(([p, ...pixel]) => [p - 3 * WIDTH, ...pixel]);
  };

  test('shows where objects were before, in the colours that they had, the oldest the faintest', async () => {
    const trail = { copies: 3, spacing: 2, opacity: 0.9 };
    assert.deepEqual(await seen(7, { trail }), [
      [1, ...colour(1), Math.round(255 * 0.3)],
      [3, ...colour(3), Math.round(255 * 0.6)],
      [5, ...colour(5), Math.round(255 * 0.9)],
      [7, ...colour(7), 255],
    ]);
    assert.deepEqual(await seen(2, { trail }), [
      [0, ...colour(0), Math.round(255 * 0.9)],
      [2, ...colour(2), 255],
    ]);
    assert.deepEqual(await seen(7, {}), [[7, ...colour(7), 255]]);
    assert.deepEqual(await bytesOf({ trail: { copies: 0 } }, clip, pictures), await bytesOf({}, clip, pictures));
  });

  test('lies behind what is newer, and mixes with it where that lets it through', async () => {
    const still = {
      ...clip,
      labels: (t) => Uint8Array.from(clip.labels(0), (label, p) => Number(p === 30 && t !== 6)),
    };
    const trail = { copies: 2, spacing: 1, opacity: 0.5 };
    assert.deepEqual(
      (await seen(5, { trail }, still)).map((pixel) => pixel.slice(1)),
      [[...colour(5), 255]],
    );
    // Frame 6 has no object: half of frame 5's over a quarter of frame 4's.
    const alpha = 1 - 0.5 * 0.75;
    const mixed = colour(5).map((value, k) => (0.5 * value + 0.5 * 0.25 * colour(4)[k]) / alpha);
    const [[, ...pixel]] = await seen(6, { trail }, still);
    assert.equal(pixel[3], Math.round(255 * alpha));
    mixed.forEach((value, k) => assert.ok(Math.abs(value - pixel[k]) <= 0.5, `${pixel} for ${mixed}`));
  });

  test('ends at a cut, has the objects that are meant, and is none of opacity alone', async () => {
    const trail = { copies: 3, spacing: 1, opacity: 1 };
    const shots = [
      { first: 0, last: 4 },
      { first: 5, last: 11 },
    ];
    const columns = async (t, options, masks_) => (await seen(t, { trail, ...options }, masks_)).map(([x]) => x);
    assert.deepEqual(await columns(6, {}, { ...clip, shots }), [5, 6]);
    assert.deepEqual(await columns(6, {}), [3, 4, 5, 6]);
    const two = { ...clip, labels: (t) => clip.labels(t).map((label) => label * (1 + (t % 2))) };
    assert.deepEqual(await columns(6, { objects: [1] }, two), [4, 6]);
    const alpha = { style: 'alpha' };
    assert.deepEqual(await bytesOf({ ...alpha, trail }, clip, pictures), await bytesOf(alpha, clip, pictures));
  });

  test('is of the frames that are named, and of no others', async () => {
    const near = (frames) => frames.map(({ t, opacity }) => [t, Math.round(1e9 * opacity) / 1e9]);
    assert.deepEqual(near(trailFrames(9, {})), [
      [0, 0.3],
      [3, 0.45],
      [6, 0.6],
    ]);
    assert.deepEqual(trailFrames(0, {}), []);
    assert.throws(() => trailFrames(-1, {}), /t = -1/);
    for (const [trail, words] of [
      [{ copies: 17 }, /trail\.copies = 17 \(expected .*0\.\.=16/],
      [{ copies: 1.5 }, /trail\.copies = 1\.5/],
      [{ spacing: 0 }, /trail\.spacing = 0 \(expected .*1\.\.=16/],
      [{ opacity: 2 }, /trail\.opacity = 2 \(expected a number, 0\.\.=1/],
      [{ length: 3 }, /length = 3 \(expected no such option; there are copies, spacing, opacity/],
      [null, /expected an object with copies/],
    ]) {
      await rejects(encodeImages(clip, pictures, { trail }), 'param', words);
      assert.throws(() => trailFrames(3, trail), words);
    }
  });
});
