// Masks at the size of the source, what a file's sound is, and about how large a video becomes.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { maskPng, masksZip } from 'tracecut';
import { enlargeMask, masksAtSize } from 'tracecut/edit';
import { estimateVideoSize, soundInfo } from 'tracecut/export';
import { RemoteEngine } from '../../dist/worker/remote.js';
import { fnv1a, plain, png, rejects, standIn } from './support.mjs';

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
    onProgress: ({ done, total }) => progress.push(`${done}/${total}`),
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
  assert.deepEqual(
    [...sizes].sort((a, b) => a - b),
    sizes,
  );
  assert.equal(estimateVideoSize(clip), sizes[2]);
  assert.equal(estimateVideoSize({ ...clip, numFrames: 200 }), 2 * sizes[2]);
  assert.ok(estimateVideoSize({ ...clip, style: 'cutout' }) < sizes[2]);
  const refused = (video, message) => assert.throws(() => estimateVideoSize(video), { code: 'param', message });
  refused({ ...clip, quality: 'best' }, /quality = "best" \(expected 'low', /);
  refused({ ...clip, width: 0 }, /width = 0/);
  refused({ ...clip, style: 'green' }, /style = "green"/);
});

/** A WAV file of silence. */
function wav(seconds, sampleRate = 8000) {
  const size = 2 * Math.round(seconds * sampleRate);
  const bytes = Buffer.alloc(44 + size);
  bytes.write('RIFF', 0);
  bytes.writeUInt32LE(36 + size, 4);
  bytes.write('WAVEfmt ', 8);
  bytes.writeUInt32LE(16, 16);
  bytes.writeUInt16LE(1, 20);
  bytes.writeUInt16LE(1, 22);
  bytes.writeUInt32LE(sampleRate, 24);
  bytes.writeUInt32LE(2 * sampleRate, 28);
  bytes.writeUInt16LE(2, 32);
  bytes.writeUInt16LE(16, 34);
  bytes.write('data', 36);
  bytes.writeUInt32LE(size, 40);
  return bytes;
}

test('the sound of a file, and which videos can hold it', async () => {
  const bytes = wav(0.5);
  const expected = { codec: 'pcm-s16', channels: 1, sampleRate: 8000, formats: ['mp4'], converted: [] };
  assert.deepEqual(await soundInfo(new Blob([bytes])), expected);
  assert.deepEqual(await soundInfo(new Uint8Array(bytes)), expected);
  assert.equal(await soundInfo(new Blob(['no file of sound at all'])), null);
});

const [WIDTH, HEIGHT] = [160, 96];
const [RADIUS, SOFT] = [30, 6];

/** Coverage of a pixel by a disc with a soft border, 0 to 1. */
const share = (x, y) => Math.min(1, Math.max(0, 0.5 + (RADIUS - Math.hypot(x - 79.3, y - 47.8)) / SOFT));
/** A bright disc on a dark background, both with some texture. */
const disc = () => plain(WIDTH, HEIGHT, (x, y) => 60 + 110 * share(x, y) + ((x * 7 + y * 13) % 9));
/** Its mask at a part of the size; the disc has this label. */
function maskOf(isInside, label = 1) {
  const [width, height] = [WIDTH / isInside, HEIGHT / isInside];
  const inside = (p) =>
    share((p % width) * isInside + isInside / 2 - 0.5, Math.floor(p / width) * isInside + isInside / 2 - 0.5) >= 0.5;
  return { width, height, labels: Uint8Array.from({ length: width * height }, (_, p) => (inside(p) ? label : 0)) };
}
const truth = Float64Array.from({ length: WIDTH * HEIGHT }, (_, p) => share(p % WIDTH, Math.floor(p / WIDTH)));
const wrong = (labels) => labels.reduce((sum, label, p) => sum + Number(label > 0 !== truth[p] >= 0.5), 0);

test('a mask of a quarter of the size comes to the border of its picture, and is as soft', async () => {
  const mask = maskOf(4);
  const originalLabels = mask.labels.slice();
  const { width, height, labels, alpha } = await enlargeMask(mask, disc());
  assert.deepEqual([width, height, labels.length, alpha.length], [WIDTH, HEIGHT, WIDTH * HEIGHT, WIDTH * HEIGHT]);
  const nearest = labels.map((_, p) => originalLabels[(Math.floor(p / WIDTH) >> 2) * mask.width + ((p % WIDTH) >> 2)]);
  assert.ok(2 * wrong(labels) < wrong(nearest), `${wrong(labels)} wrong, ${wrong(nearest)} of the nearest`);
  const error = (values) => values.reduce((sum, value, p) => sum + Math.abs(value - truth[p]), 0);
  const [soft, hard] = [error(Float64Array.from(alpha, (a) => a / 255)), error(Float64Array.from(labels))];
  assert.ok(soft < 0.8 * hard, `off by ${soft} in all, ${hard} without opacity`);
  alpha.forEach((a, p) => assert.equal(a >= 128, labels[p] > 0));
  assert.deepEqual(mask.labels, originalLabels);
});

test('files, pixels and a worker give the same bytes as every machine', async (t) => {
  const mask = maskOf(2);
  const large = await enlargeMask(mask, disc());
  assert.deepEqual(await enlargeMask(mask, png(disc())), large);
  assert.deepEqual(await enlargeMask(mask, new Blob([png(disc())])), large);
  const worker = standIn();
  t.after(() => worker.terminate());
  const engine = new RemoteEngine(worker);
  const module = await WebAssembly.compile(await readFile(new URL('../../dist/decoder_bg.wasm', import.meta.url)));
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
  const mask = maskOf(2, 3);
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
  const mask = maskOf(1);
  assert.deepEqual((await enlargeMask(mask, disc())).labels, mask.labels);
  const flat = await enlargeMask(mask, plain(WIDTH, HEIGHT, 90));
  assert.deepEqual(flat.labels, mask.labels);
  assert.deepEqual(
    flat.alpha,
    mask.labels.map((label) => 255 * label),
  );
});

test('what cannot be used is refused', async () => {
  const mask = maskOf(2);
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
  assert.equal((await enlargeMask(mask, disc())).width, WIDTH);
});
