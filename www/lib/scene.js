// How the scene moves in the picture: what the camera does, seen from the background's trajectories.

import { illegal } from './errors.js';

/**
 * Trajectories whose labels are known: a `Result`, the result of a segmented video, or an object of the caller's with
 * `trajectories` as theirs, each with its `label`.
 * @typedef {object} LabelledTrajectories
 * @property {number} numFrames
 * @property {{count: number, startFrame: Uint32Array, offset: Uint32Array, x: Float32Array, y: Float32Array, label?:
 *   ArrayLike<number>}} trajectories
 * @property {{label: ArrayLike<number>, object?: ArrayLike<number> | null}} [clusters]
 */

/**
 * Where the scene lies in each frame as against the first, in pixels: a camera that pans to the right moves it to the
 * left.
 * @typedef {{readonly x: Float64Array<ArrayBuffer>, readonly y: Float64Array<ArrayBuffer>}} SceneMotion
 */

/** Trajectories of a frame that are listened to: their median is no better with more. */
const ENOUGH = 400;

/**
 * How far the scene has moved in the picture: from frame to frame the median of the background's trajectories. Turning
 * and zooming about the middle are no such motion; across a cut, or where no background is seen, nothing moves.
 *
 * ```js
 * const { x } = sceneMotion(result); // An object at column c of frame t is at c - x[t] of the first frame's scene.
 * ```
 * @param {LabelledTrajectories} result
 * @returns {SceneMotion}
 */
export function sceneMotion(result) {
  const { numFrames, trajectories, clusters } = result ?? {};
  const known = trajectories?.label ?? clusters?.label;
  if (!known || !(numFrames >= 1))
    throw illegal('data', 'result', result, 'a result with trajectories and their labels');
  const { count, startFrame, offset, x, y, label } = trajectories;
  const ofCluster = label ? null : clusters?.object;
  const isScene = (/** @type {number} */ i) => (ofCluster ? ofCluster[Number(known[i])] : known[i]) === 0;
  const scene = Array.from({ length: count }, (_, i) => i).filter(isScene);
  const points = scene.reduce((sum, i) => sum + Number(offset[i + 1]) - Number(offset[i]), 0);
  const every = Math.max(1, Math.floor(points / (numFrames * ENOUGH)));
  const steps = Array.from({ length: numFrames }, () => ({
    x: /** @type {number[]} */ ([]),
    y: /** @type {number[]} */ ([]),
  }));
  for (let k = 0; k < scene.length; k += every) {
    const i = Number(scene[k]);
    const [first, begin, end] = [Number(startFrame[i]), Number(offset[i]), Number(offset[i + 1])];
    for (let p = begin + 1; p < end; p += 1) {
      const step = steps[first + p - begin];
      step?.x.push(Number(x[p]) - Number(x[p - 1]));
      step?.y.push(Number(y[p]) - Number(y[p - 1]));
    }
  }
  return { x: summed(steps.map((step) => median(step.x))), y: summed(steps.map((step) => median(step.y))) };
}

/** @param {number[]} values 0 where there are none */
function median(values) {
  const sorted = Float64Array.from(values).sort();
  const middle = sorted.length >> 1;
  if (sorted.length % 2 === 1) return Number(sorted[middle]);
  return sorted.length === 0 ? 0 : (Number(sorted[middle - 1]) + Number(sorted[middle])) / 2;
}

/** @param {number[]} steps */
function summed(steps) {
  let sum = 0;
  return Float64Array.from(steps, (step) => (sum += step));
}
