// Trajectories from outside, checked.

import { describe, illegal, isPlainObject, wholeNumber } from './errors.js';

/**
 * Trajectories of any tracker. The points of trajectory `i` are `offset[i]` to `offset[i + 1]` of `x` and `y`, one for
 * each
 * of the consecutive frames from `startFrame[i]` on.
 * @typedef {object} TrajectoryInput
 * @property {number} numFrames of the clip
 * @property {number} width of its frames in pixels
 * @property {number} height of its frames in pixels
 * @property {Uint32Array | readonly number[]} startFrame the first frame of each trajectory
 * @property {Uint32Array | readonly number[]} offset where the points of each begin; one longer than `startFrame`
 * @property {Float32Array | Float64Array | readonly number[]} x of all points, in input pixels
 * @property {Float32Array | Float64Array | readonly number[]} y of all points, in input pixels
 */

/**
 * Trajectories on their way to the engine.
 * @typedef {{numFrames: number, width: number, height: number, startFrame: Uint32Array<ArrayBuffer>,
 *   offset: Uint32Array<ArrayBuffer>, x: Float32Array<ArrayBuffer>, y: Float32Array<ArrayBuffer>}} RawTrajectories
 */

const MAX_SIDE = 16384;
const MAX_FRAMES = 1000000;
const MAX_U32 = 4294967295;

/**
 * Checks types and copies; the law of the arrays themselves is checked in Rust.
 * @param {TrajectoryInput} input
 * @returns {RawTrajectories}
 */
export function toRawTrajectories(input) {
  if (!isPlainObject(input)) {
    throw illegal('data', 'trajectories', input, 'an object {numFrames, width, height, startFrame, offset, x, y}');
  }
  return {
    numFrames: wholeNumber('data', 'numFrames', input.numFrames, 1, MAX_FRAMES),
    width: wholeNumber('frame-size', 'width', input.width, 1, MAX_SIDE),
    height: wholeNumber('frame-size', 'height', input.height, 1, MAX_SIDE),
    startFrame: wholeNumbers('startFrame', input.startFrame),
    offset: wholeNumbers('offset', input.offset),
    x: numbers('x', input.x),
    y: numbers('y', input.y),
  };
}

/**
 * @param {string} name
 * @param {unknown} values
 */
function wholeNumbers(name, values) {
  if (values instanceof Uint32Array) return new Uint32Array(values);
  if (!Array.isArray(values)) throw illegal('data', name, values, 'a Uint32Array');
  values.forEach((value, i) => wholeNumber('data', `${name}[${i}]`, value, 0, MAX_U32));
  return new Uint32Array(values);
}

/**
 * @param {string} name
 * @param {unknown} values
 */
function numbers(name, values) {
  if (values instanceof Float32Array || values instanceof Float64Array) return new Float32Array(values);
  if (!Array.isArray(values)) throw illegal('data', name, values, 'a Float32Array');
  const wrong = values.findIndex((value) => typeof value !== 'number');
  if (wrong >= 0) throw illegal('data', `${name}[${wrong}]`, describe(values[wrong]), 'a number of pixels');
  return new Float32Array(values);
}
