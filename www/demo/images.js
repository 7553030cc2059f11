/** Images of a sequence, or one image, animated or still, as a source of frames. @module */

import { Grabber, openVideo } from './video.js';
import { PageError } from './words.js';

/** Frames per second at which images of a sequence are shown; nothing says how they were taken. */
const SEQUENCE_FPS = 15;

/** Motion needs two frames: damage after fewer is an error. */
const FEWEST = 2;

/**
 * @param {File[]} files
 * @returns {Promise<import('./source.js').Source>}
 */
export async function openImages(files) {
  if (files.length === 1) return openOne(files[0]);
  const inOrder = new Intl.Collator('en', { numeric: true });
  const sorted = [...files].sort((a, b) => inOrder.compare(a.name, b.name));
  const first = await decode(sorted[0]);
  const size = { width: first.width, height: first.height };
  first.close();
  const grabber = new Grabber();
  return pictureSource(
    `${sorted[0].name} … ${sorted[sorted.length - 1].name}`,
    sorted.length,
    size,
    async (k, side) => {
      const picture = await decode(sorted[k]);
      if (picture.width !== size.width || picture.height !== size.height) {
        const found = `${picture.width}×${picture.height}`;
        const wanted = `${size.width}×${size.height}`;
        throw new PageError('mixed-sizes', `${sorted[k].name} is ${found}, the first is ${wanted}`);
      }
      const pixels = grabber.grab(picture, size, side);
      picture.close();
      return pixels;
    },
  );
}

/**
 * A GIF, or another image that may hold several frames; or a still one.
 *
 * @param {File} file
 * @returns {Promise<import('./source.js').Source>}
 */
async function openOne(file) {
  const picture = await decode(file);
  // Not every browser has one.
  if (typeof ImageDecoder === 'undefined' || !(await ImageDecoder.isTypeSupported(file.type))) {
    // Whether a GIF holds more than one frame is not to be known here.
    if (file.type === 'image/gif') throw new PageError('animated', file.name);
    return stillSource(file.name, picture);
  }
  const decoder = new ImageDecoder({ data: await file.arrayBuffer(), type: file.type });
  await decoder.tracks.ready;
  // One that is cut off has the frames before.
  await decoder.completed.catch(() => {});
  const { frameCount } = decoder.tracks.selectedTrack ?? { frameCount: 1 };
  decoder.close();
  if (frameCount < 2) return stillSource(file.name, picture);
  picture.close();
  // Its frames last as long as it says.
  return openVideo(file, 'images');
}

/**
 * @param {string} name
 * @param {ImageBitmap} picture
 * @returns {import('./source.js').Source}
 */
function stillSource(name, picture) {
  const { width, height } = picture;
  const grabber = new Grabber();
  const read = async (/** @type {number} */ _, /** @type {number} */ side) =>
    grabber.grab(picture, { width, height }, side);
  const source = pictureSource(name, 1, { width, height }, read);
  return { ...source, kind: 'still', strip: undefined, close: () => picture.close() };
}

/**
 * @param {string} name
 * @param {number} count
 * @param {{width: number, height: number}} size
 * @param {(frame: number, side: number) => Promise<ImageData>} read
 * @returns {import('./source.js').Source}
 */
function pictureSource(name, count, size, read) {
  /** @type {import('./source.js').Source} */
  const source = {
    kind: 'images',
    name,
    ...size,
    fps: SEQUENCE_FPS,
    count,
    preview: read,
    async *strip(most, side, signal) {
      const shown = Math.min(most, count);
      for (let k = 0; k < shown; k++) {
        signal.throwIfAborted();
        yield read(Math.floor(((k + 0.5) * count) / shown), side);
      }
    },
    async *frames(take, signal) {
      source.damage = null;
      for (let k = 0; k < take.frames; k++) {
        signal.throwIfAborted();
        const frame = await read(take.start + k * take.step, take.side).catch((error) => {
          if (k < FEWEST || error?.code !== 'unreadable-image') throw error;
          source.damage = { frames: k, total: take.frames };
          return null;
        });
        if (!frame) return;
        yield { frame, time: null };
      }
    },
    close() {},
  };
  return source;
}

/**
 * @param {File} file
 * @returns {Promise<ImageBitmap>}
 */
async function decode(file) {
  try {
    return await createImageBitmap(file);
  } catch {
    throw new PageError('unreadable-image', file.name);
  }
}
