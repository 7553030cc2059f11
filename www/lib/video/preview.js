// A first look at a clip, long before its masks are there.

import { illegal } from '../errors.js';
import { isPlainObject } from '../options.js';
import { asOptions } from './options.js';
import { segment } from './segment.js';

/**
 * Frames that are far apart show motion that few of them suffice to see; much farther, and fast things are lost. Figures
 * for other choices are in docs/speed.md.
 */
const USUAL = { step: 2, maxFrames: 8, threads: 1 };
const USUAL_SIDE = 320;

/**
 * @param {import('./source.js').VideoSource} source
 * @param {import('./segment.js').VideoOptions | undefined} options
 * @param {import('../platform.js').Platform} platform
 * @returns {Promise<import('./result.js').VideoResult>}
 */
export async function preview(source, options, platform) {
  const { clip = {}, ...given } = /** @type {import('./segment.js').VideoOptions} */ (asOptions(options));
  if (!isPlainObject(clip)) throw illegal('param', 'clip', clip, 'an object such as {maxSide: 240}');
  const taken = Object.fromEntries(Object.entries(given).filter(([, value]) => value !== undefined));
  const maxSide = clip.maxSide ?? USUAL_SIDE;
  return segment(source, { ...USUAL, ...taken, clip: { ...clip, maxSide } }, platform).collect();
}
