/** Opens sources of frames: the sample, and files. @module */

import { sortFiles, synthClip } from '../model/library.js';
import { openImages } from './images.js';
import { openVideo } from './video.js';
import { PageError } from '../model/words.js';

/** @typedef {import('../model/source.js').Source} Source */

/** The sample: small enough to be through in seconds, large enough to look at. */
export const SAMPLE = { width: 480, height: 270, frames: 24, seed: 0 };

/**
 * @returns {Promise<Source & {clip: import('../model/library.js').Clip}>} the library's own scene, with its known masks under `clip`
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
