// What the tests of the package share: clips, a PNG writer, and checks of errors.

import assert from 'node:assert/strict';
import { deflateSync } from 'node:zlib';
import { createSession, synthClip, TraceCutError } from 'tracecut';

/** Small enough to run in a second, large enough to move: the scene of most tests. */
export const SMALL = { width: 128, height: 72, frames: 8, seed: 3 };

/** The frames of a synthetic clip. */
export async function framesOf(options = SMALL) {
  const clip = await synthClip(options);
  return Array.from({ length: clip.numFrames }, (_, t) => clip.frame(t));
}

/** A frame of one colour, or of `colour(x, y)`. */
export function plain(width, height, colour = 0) {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    const value = typeof colour === 'function' ? colour(p % width, Math.floor(p / width)) : colour;
    data.set([value, value, value, 255], 4 * p);
  }
  return { data, width, height };
}

/** Opens a session, pushes the frames, runs it and closes it. */
export async function segment(frames, options) {
  const session = await createSession(options);
  try {
    for (const frame of frames) await session.push(frame);
    return await session.run();
  } finally {
    session.close();
  }
}

/** Everything of a result that must not differ between two runs, as one text. */
export function fingerprint(result) {
  const { trajectories, clusters, embedding } = result;
  const edges = Array.from({ length: result.numFrames }, (_, t) => Object.values(result.edges(t)).map((a) => [...a]));
  const lists = [trajectories.startFrame, trajectories.offset, trajectories.x, trajectories.y, clusters.label, embedding.eigenvalues,
    embedding.vectors];
  return JSON.stringify([clusters.count, lists.map((list) => [...list]), edges]);
}

/** Checks that `promise` rejects with a TraceCutError of this code whose message matches. */
export async function rejects(promise, code, message = /./) {
  await assert.rejects(promise, (error) => {
    assert.ok(error instanceof TraceCutError, `${error?.stack ?? error} is no TraceCutError`);
    assert.equal(error.code, code, error.message);
    assert.match(error.message, message);
    return true;
  });
}

/** A PNG file: RGB, eight bits. Its header may claim another size. */
export function png({ data, width, height }, claim = [width, height]) {
  const rows = Buffer.alloc(height * (1 + 3 * width));
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const pixel = 4 * (y * width + x);
      rows.set(data.subarray(pixel, pixel + 3), y * (1 + 3 * width) + 1 + 3 * x);
    }
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(claim[0], 0);
  header.writeUInt32BE(claim[1], 4);
  header.set([8, 2, 0, 0, 0], 8);
  const magic = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  return new Uint8Array(Buffer.concat([magic, chunk('IHDR', header), chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]));
}

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const whole = Buffer.alloc(body.length + 8);
  whole.writeUInt32BE(data.length, 0);
  body.copy(whole, 4);
  whole.writeUInt32BE(crc32(body), body.length + 4);
  return whole;
}

function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit += 1) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}
