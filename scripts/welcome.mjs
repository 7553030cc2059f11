// `node scripts/welcome.mjs`: the moving picture of the first screen, made by the package from its drawn sample. Left of the
// middle are the frames, right of it their objects. Needs ffmpeg with SVT-AV1, and takes minutes.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { join } from 'node:path';
import { createSession, synthClip } from '../dist/node.js';
import { masksAtSize } from '../dist/node/edit.js';
import { root } from './tools.mjs';

const [WIDTH, HEIGHT, FRAMES, FPS] = [1440, 810, 48, 12];

/** The frame without motion, for people who want none. */
const STILL_FRAME = 30;

/** Colours of the line in the middle and of the ground right of it, grey. */
const [LINE, GROUND] = [0xff, 0x26];

/** Largest quantizers by eye. */
const MOVING = ['-c:v', 'libsvtav1', '-preset', '3', '-crf', '62', '-g', '300', '-svtav1-params', 'tune=0'];
const STILL = ['-c:v', 'libaom-av1', '-still-picture', '1', '-crf', '42', '-cpu-used', '4'];

const clip = await synthClip({ width: WIDTH, height: HEIGHT, frames: FRAMES, seed: 0 });
const frames = Array.from({ length: FRAMES }, (_, t) => clip.frame(t));
const session = await createSession();
for (const frame of frames) await session.push(frame);
const result = await session.run();
const labels = (/** @type {number} */ t) => result.labels(t);
const shots = [{ first: 0, last: FRAMES - 1 }];
const masks = await masksAtSize(
  { width: WIDTH, height: HEIGHT, numFrames: FRAMES, labels, times: null, end: null, shots },
  frames,
  {},
);
const pictures = frames.map(({ data }, t) => compose(data, masks.labels(t)));
await encode('sample.avif', pictures, MOVING);
await encode('still.avif', [pictures[STILL_FRAME]], STILL);

/** @param {Uint8Array | Uint8ClampedArray} rgba @param {Uint8Array} mask */
function compose(rgba, mask) {
  const rgb = Buffer.alloc(3 * WIDTH * HEIGHT);
  for (let p = 0; p < WIDTH * HEIGHT; p += 1) {
    const x = p % WIDTH;
    const isLine = Math.abs(x - WIDTH / 2) <= 2;
    const alpha = x < WIDTH / 2 ? 1 : coverage(mask, p);
    for (let c = 0; c < 3; c += 1)
      rgb[3 * p + c] = isLine ? LINE : Math.round(alpha * rgba[4 * p + c] + (1 - alpha) * GROUND);
  }
  return rgb;
}

/** Returns the share of objects in the 3 × 3 pixels around a pixel. @param {Uint8Array} mask @param {number} p */
function coverage(mask, p) {
  let count = 0;
  for (const down of [-WIDTH, 0, WIDTH]) for (const across of [-1, 0, 1]) count += mask[p + down + across] > 0 ? 1 : 0;
  return count / 9;
}

/** @param {string} name @param {Buffer[]} images @param {string[]} codec */
async function encode(name, images, codec) {
  const raw = ['-f', 'rawvideo', '-pix_fmt', 'rgb24', '-s', `${WIDTH}x${HEIGHT}`, '-r', String(FPS), '-i', '-'];
  const file = join(root, 'studio', 'view', 'welcome', name);
  const args = ['-y', '-loglevel', 'error', ...raw, '-pix_fmt', 'yuv420p', ...codec, '-f', 'avif', file];
  const ffmpeg = spawn('ffmpeg', args, { stdio: ['pipe', 'inherit', 'inherit'] });
  const ended = once(ffmpeg, 'close');
  for (const image of images) if (!ffmpeg.stdin.write(image)) await once(ffmpeg.stdin, 'drain');
  ffmpeg.stdin.end();
  await ended;
}
