// Options of video functions: what is taken of a source, and how it is cut into windows.

import { illegal } from '../errors.js';
import { isPlainObject, wholeNumber } from '../options.js';

/**
 * What is taken of a source: the frames whose time lies in `[start, end)`, every `step`-th of them, at most
 * `maxFrames`.
 * @typedef {object} TakeOptions
 * @property {number} [start] seconds; the clip's begin if not given
 * @property {number} [end] seconds; the clip's end if not given
 * @property {number} [step] every `step`-th frame; 1 if not given
 * @property {number} [maxFrames] at most so many frames; all if not given
 * @property {number} [size] the long side in pixels that frames are reduced to; a smaller frame stays as it is
 * @property {number} [frameRate] frames per second of a list of frames that carry no times; 25 if not given
 * @property {'auto' | 'webcodecs' | 'seeking'} [decoding] how a video file is decoded: `'auto'` takes WebCodecs and
 *   falls back to seeking a video element
 * @property {import('../options.js').WasmSource} [decoder] where the wasm file is that reads PNG and JPEG files, when
 *   not beside the package
 * @property {AbortSignal} [signal] ends the work: what is awaited rejects with its reason
 * @property {(damage: Damage) => void} [onDamage] with it, a source that is cut off or damaged ends before the damage,
 *   which this is told of; without it, and where fewer than two frames come before, that is an error (`truncated`,
 *   `decode`)
 */

/**
 * Damage that a source ends with: how many frames were taken before it, how many should have been, null where nobody
 * knows, and what is wrong. @typedef {{frames: number, total: number | null, error:
 * import('../errors.js').TraceCutError}} Damage
 */

/**
 * @typedef {object} Take
 * @property {number} start
 * @property {number} end
 * @property {number} step
 * @property {number} maxFrames
 * @property {number | undefined} size
 * @property {number} frameRate
 * @property {'auto' | 'webcodecs' | 'seeking'} decoding
 * @property {AbortSignal | undefined} signal
 * @property {((damage: Damage) => void) | undefined} onDamage
 */

const MAX_FRAMES = 1_000_000;
const MAX_SIDE = 16384;
const DECODINGS = ['auto', 'webcodecs', 'seeking'];

/** Windows of fewer frames see too little motion, larger ones take too much memory. */
const MAX_WINDOW = 400;

/** Frames of a window, and how many of them the next one shares, where nobody says. */
export const WINDOW = 50;
export const OVERLAP = 10;

/**
 * @param {unknown} options
 * @returns {Record<string, unknown>}
 */
export function asOptions(options) {
  if (options === undefined) return {};
  if (!isPlainObject(options))
    throw illegal('param', 'options', options, 'an object such as {start: 0, end: 2, size: 480}');
  return options;
}

/**
 * Checks what both `videoFrames` and `segmentVideo` take, and gives what is left.
 * @param {Record<string, unknown>} options
 * @returns {{take: Take, others: Record<string, unknown>}}
 */
export function splitTake(options) {
  const {
    start = -Infinity,
    end = Infinity,
    step = 1,
    maxFrames = Infinity,
    size,
    frameRate = 25,
    decoding = 'auto',
    signal,
    onDamage,
    ...others
  } = options;
  if (start !== -Infinity) seconds('start', start);
  if (end !== Infinity) seconds('end', end);
  if (Number(end) <= Number(start)) throw illegal('param', 'end', end, `more than start = ${start}`);
  wholeNumber('param', 'step', step, 1, MAX_FRAMES);
  if (maxFrames !== Infinity) wholeNumber('param', 'maxFrames', maxFrames, 1, MAX_FRAMES);
  if (size !== undefined) wholeNumber('param', 'size', size, 16, MAX_SIDE);
  if (typeof frameRate !== 'number' || !(frameRate > 0 && frameRate <= 1000)) {
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0 and at most 1000');
  }
  if (!DECODINGS.includes(/** @type {string} */ (decoding)))
    throw illegal('param', 'decoding', decoding, "'auto', 'webcodecs' or 'seeking'");
  if (signal !== undefined && !isSignal(signal)) throw illegal('param', 'signal', signal, 'an AbortSignal');
  if (onDamage !== undefined && typeof onDamage !== 'function')
    throw illegal('param', 'onDamage', onDamage, 'a function of what was damaged');
  const take = /** @type {Take} */ ({ start, end, step, maxFrames, size, frameRate, decoding, signal, onDamage });
  return { take, others };
}

/**
 * @param {Record<string, unknown>} options
 * @returns {{window: number, overlap: number, others: Record<string, unknown>}}
 */
export function splitWindow(options) {
  const { window = WINDOW, overlap = OVERLAP, ...others } = options;
  const frames = wholeNumber('param', 'window', window, 2, MAX_WINDOW);
  // A small window gets a small overlap without having to ask for it.
  const shared =
    options.overlap === undefined
      ? Math.min(OVERLAP, frames - 1)
      : wholeNumber('param', 'overlap', overlap, 1, frames - 1);
  return { window: frames, overlap: shared, others };
}

/**
 * @param {string} name
 * @param {unknown} value
 */
function seconds(name, value) {
  if (typeof value !== 'number' || !Number.isFinite(value)) throw illegal('param', name, value, 'a number of seconds');
}

/**
 * @param {unknown} signal
 * @returns {signal is AbortSignal}
 */
function isSignal(signal) {
  return typeof signal === 'object' && signal !== null && 'aborted' in signal && 'addEventListener' in signal;
}
