// A first look at a clip, long before its masks are there.

import { illegal, isPlainObject } from '../errors.js';
import { asOptions } from './options.js';
import { segmentVideo } from './segment.js';

/**
 * Frames that are far apart show motion that few of them suffice to see; much farther, and fast things are lost. Figures
 * for other choices are in docs/speed.md.
 */
const USUAL = { step: 2, maxFrames: 8, threads: 1 };
const USUAL_SIDE = 320;

/**
 * Coarse masks of a clip's first frames, long before its own are there: those of frames 0, 2, 4, … 14, made from pictures
 * of at most 320 pixels, on one thread. Where something moves is mostly right; small and slow things may be missing, and
 * labels are not those that the whole clip will have. Takes what `segmentVideo` takes, with `step: 2`, `maxFrames: 8`,
 * `threads: 1` and `clip.maxSide: 320` where the options say nothing else, and rejects as that does.
 *
 * ```js
 * const coarse = await previewMasks(file, { size: 480 });
 * drawLabels(context, coarse, 0);
 * ```
 * @param {import('./source.js').VideoSource} source
 * @param {import('./segment.js').VideoOptions} [options]
 * @returns {Promise<import('./result.js').VideoResult>} of the frames taken, at the size of the source or `size`
 */
export async function previewMasks(source, options) {
  const { clip = {}, ...given } = /** @type {import('./segment.js').VideoOptions} */ (asOptions(options));
  if (!isPlainObject(clip)) throw illegal('param', 'clip', clip, 'an object such as {maxSide: 240}');
  const taken = Object.fromEntries(Object.entries(given).filter(([, value]) => value !== undefined));
  const maxSide = clip.maxSide ?? USUAL_SIDE;
  return segmentVideo(source, { ...USUAL, ...taken, clip: { ...clip, maxSide } }).collect();
}
