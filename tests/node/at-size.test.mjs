// Masks at the size of the source, what a file's sound is, and about how large a video becomes.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { maskPng, masksZip } from 'tracecut';
import { masksAtSize } from 'tracecut/edit';
import { estimateVideoSize, soundInfo } from 'tracecut/export';
import { plain, rejects } from './support.mjs';

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
  const same = await masksAtSize(masks, [plain(4, 2), plain(4, 2), plain(4, 2)]);
  for (let t = 0; t < 3; t += 1) assert.deepEqual(same.labels(t), masks.labels(t));
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
  await rejects(masksAtSize(masks, [], { size: 4 }), 'param', /size = 4 \(expected no such option/);
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
