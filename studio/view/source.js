/**
 * Where frames come from. Each kind of source answers the same questions, so the rest of the page does not care.
 * @module
 */

import { sortFiles, synthClip } from './library.js';
import { openImages } from './images.js';
import { openVideo } from './video.js';
import { DEFAULT_TAKE } from './store.js';
import { PageError } from './words.js';

/**
 * What to take from a source.
 *
 * @typedef {object} Take
 * @property {number} start index of the first frame
 * @property {number} frames how many
 * @property {number} step 1 takes every frame, 2 every second one, …
 * @property {number} side long side of the working size in pixels; a smaller source stays as it is
 */

/**
 * @typedef {object} Source
 * @property {'sample' | 'video' | 'images' | 'still'} kind
 * @property {string} name
 * @property {number} width in pixels
 * @property {number} height
 * @property {number} fps frames per second, on average; a convention for images
 * @property {number} count frames there are (for a video: about)
 * @property {(frame: number, side: number, time?: number) => Promise<ImageData>} preview one frame; found by its time in
 *   seconds where that is known
 * @property {(count: number, side: number, signal: AbortSignal) => AsyncIterable<ImageData>} [strip] `count` frames, or
 *   all where there are fewer, evenly spread, of at most this long side; what cannot be trimmed has none
 * @property {ArrayLike<number> | null} [times] of all frames in seconds, where the file says them
 * @property {number} [end] when the last frame ends, in seconds, where the file says it
 * @property {{frames: number, total: number | null} | null} [damage] what `frames` ended with when it was last read:
 *   `frames` come before the damage, of `total`
 * @property {File} [file] the file of a video
 * @property {string} [type] its media type, by its content
 * @property {File[]} [files] all that it was opened from; the sample has none
 * @property {(take: Take, signal: AbortSignal) => AsyncIterable<{frame: ImageData, time: number | null, end?:
 *   number | null}>} frames with their times, and when they end, in seconds; null where nothing says
 * @property {() => void} close
 */

/**
 * @param {Source | null} source
 * @returns {'clip' | 'still'} whether it has motion
 */
export function kindOf(source) {
  return source?.kind === 'still' ? 'still' : 'clip';
}

/**
 * @param {Source} source
 * @returns {Take} what is taken of it when nobody chooses
 */
export function usualTake(source) {
  const side = source.kind === 'sample' ? source.width : DEFAULT_TAKE.side;
  return fitTake({ ...DEFAULT_TAKE, frames: source.count, side }, source);
}

/** The sample: small enough to be through in seconds, large enough to look at. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };

/**
 * @returns {Promise<Source & {clip: import('./library.js').Clip}>} the library's own scene, with its known masks under `clip`
 */
export async function sampleSource() {
  const clip = await synthClip(SAMPLE);
  const imageOf = (/** @type {number} */ t) => {
    const { data, width, height } = clip.frame(t);
    return new ImageData(new Uint8ClampedArray(data), width, height);
  };
  return {
    clip,
    kind: 'sample',
    name: 'Sample clip',
    width: clip.width,
    height: clip.height,
    fps: 15,
    count: clip.numFrames,
    preview: async (frame) => imageOf(frame),
    async *frames(take) {
      for (let t = 0; t < take.frames; t++) {
        yield { frame: imageOf(t), time: t / 15, end: (t + 1) / 15 };
        // Lets the page draw in between.
        await new Promise((resolve) => setTimeout(resolve));
      }
    },
    close() {},
  };
}

/**
 * @param {File[]} chosen
 * @returns {Promise<Source>}
 */
export async function openFiles(chosen) {
  const found = await sortFiles(chosen);
  const files = found.map(({ file }) => file);
  const stranger = found.find(({ kind }) => kind === null);
  if (files.length === 0 || stranger) throw new PageError('unknown-file', strangerWords(stranger?.file));
  const areImages = found.every(({ kind }) => kind === 'image');
  if (!areImages && files.length > 1) {
    const code = found.some(({ kind }) => kind === 'image') ? 'mixed-files' : 'many-videos';
    throw new PageError(code, `${files.length} files`);
  }
  const type = found[0].type ?? '';
  const source = areImages ? await openImages(files, type) : await openVideo(files[0]);
  return Object.assign(source, { files, type });
}

/** @param {File} [file] */
const strangerWords = (file) => (file?.size === 0 ? `${file.name} is empty` : (file?.name ?? ''));

/**
 * @param {Take} take
 * @param {Source} source
 * @returns {Take} within what the source has
 */
export function fitTake(take, source) {
  const start = Math.max(0, Math.min(take.start, source.count - 2));
  const room = Math.floor((source.count - 1 - start) / take.step) + 1;
  return { ...take, start, frames: Math.max(1, Math.min(take.frames, room)) };
}
