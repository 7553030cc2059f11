// Raw video from streams.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Readable } from 'node:stream';
import { createSession, framesOfRaw, segmentVideo } from 'tracecut/node';
import { all, fnv1a, framesOf, rejects } from './support.mjs';

const rgb = ({ data }) => data.filter((_, k) => k % 4 < 3);

test('raw frames are read in every format', async () => {
  const one = async (format, bytes) => {
    const [{ frame }] = await all(framesOfRaw([Uint8Array.from(bytes)], { width: 2, height: 1, format }));
    assert.deepEqual([frame.width, frame.height, frame.data[3], frame.data[7]], [2, 1, 255, 255]);
    return [...rgb(frame)];
  };
  assert.deepEqual(await one('rgba', [1, 2, 3, 9, 4, 5, 6, 9]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('bgra', [3, 2, 1, 9, 6, 5, 4, 9]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('rgb24', [1, 2, 3, 4, 5, 6]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('bgr24', [3, 2, 1, 6, 5, 4]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('gray', [7, 8]), [7, 7, 7, 8, 8, 8]);
});

const grey = { width: 2, height: 1, format: 'gray', frameRate: 4 };

test('frames have numbers and times, however the stream is cut into pieces', async () => {
  const bytes = [1, 2, 3, 4, 5, 6];
  for (const size of [1, 4, 6]) {
    const pieces = bytes
      .filter((_, k) => k % size === 0)
      .map((_, k) => Uint8Array.from(bytes.slice(k * size, (k + 1) * size)));
    for (const source of [pieces, Readable.from(pieces), Readable.toWeb(Readable.from(pieces))]) {
      const frames = await all(framesOfRaw(source, grey));
      assert.deepEqual(
        frames.map(({ frame, index, time, duration }) => [frame.data[0], index, time, duration]),
        [0, 1, 2].map((k) => [2 * k + 1, k, k / 4, 1 / 4]),
      );
    }
  }
  assert.deepEqual(await all(framesOfRaw([], grey)), []);
});

test('a stream that is cut off gives the frames before that, then an error that counts them', async () => {
  const seen = [];
  const reading = (async () => {
    for await (const { index } of framesOfRaw([Uint8Array.of(1, 2, 3)], grey)) seen.push(index);
  })();
  await rejects(reading, 'truncated', /frame 1 of the stream has 1 bytes \(expected 2\)/);
  await assert.rejects(reading, { frames: 1 });
  assert.deepEqual(seen, [0]);
});

test('what cannot be read is refused before memory is taken', async () => {
  const refused = (options, code, message) => rejects(all(framesOfRaw([], { ...grey, ...options })), code, message);
  await refused({ format: 'yuv420p' }, 'param', /format = "yuv420p" \(expected rgba, bgra, rgb24, bgr24, gray\)/);
  await refused({ width: 16384, height: 16384 }, 'too-large', /268435456 pixels in a frame .*the parameter maxPixels/);
  await refused({ width: 0 }, 'frame-size', /width = 0/);
  await refused({ maxPixels: 1 }, 'too-large', /expected at most 1;/);
  await refused({ maxPixels: 0 }, 'param', /maxPixels = 0/);
  await refused({ frameRate: 0 }, 'param', /frameRate/);
  await refused({ pixels: 1 }, 'param', /pixels/);
  await rejects(all(framesOfRaw('clip.rgb', grey)), 'data', /source = "clip.rgb"/);
  await rejects(all(framesOfRaw(['words'], grey)), 'data', /a piece of the stream/);
});

test('what is not read of a stream is given up', async () => {
  let closed = false;
  async function* endless() {
    try {
      for (;;) yield Uint8Array.of(1, 2);
    } finally {
      closed = true;
    }
  }
  for await (const { index } of framesOfRaw(endless(), grey)) if (index === 2) break;
  assert.ok(closed);
});

test('a session and segmentVideo take them', async () => {
  const frames = await framesOf();
  const { width, height } = frames[0];
  const bytes = frames.map(({ data }) => new Uint8Array(data));
  const raw = () => framesOfRaw(bytes, { width, height, format: 'rgba' });
  const expected = await segmentVideo(frames).collect();
  const found = await segmentVideo(raw()).collect();
  assert.equal(fnv1a(found.labels(3)), fnv1a(expected.labels(3)));
  const session = await createSession();
  for await (const { frame } of raw()) await session.push(frame);
  assert.equal(session.numFrames, frames.length);
  session.close();
});
