// Where a run looked: what can be said of a clip in which nothing was found.

import { TraceCutError, illegal } from './errors.js';

/**
 * What a report needs of a result: `Result`, `VideoResult`, or the like.
 * @typedef {object} Searched
 * @property {number} width in pixels
 * @property {number} height
 * @property {number} numFrames
 * @property {{count: number, offset: ArrayLike<number>, x: ArrayLike<number>, y: ArrayLike<number>}} trajectories
 * @property {{count: number, label: ArrayLike<number>}} [clusters]
 */

/**
 * Where a run looked. `coverage` is the part of the picture, 0 to 1, that trajectories went over: of squares whose side
 * is a sixteenth of the longer side of the picture, those that a trajectory was in. `speed` is the median motion of
 * their points, in pixels a frame; the camera counts as moving (`cameraMoves`) where that is above a thousandth of the
 * longer side. `motions` are the parts of all points that each cluster holds, the largest first; null for a result of
 * many windows, which has no clusters.
 * @typedef {{readonly numFrames: number, readonly trajectories: number, readonly coverage: number, readonly speed:
 *   number, readonly cameraMoves: boolean, readonly motions:
 *   number[] | null}} SearchReport
 */

/** Squares along the longer side. */
const SQUARES = 16;

/** Motion that is the camera's, in longer sides a frame: half a pixel at the usual working size. */
const STILL = 0.001;

/**
 * Where a run looked, from its trajectories.
 * @param {Searched} result
 * @returns {SearchReport}
 */
export function searchReport(result) {
  if (typeof result !== 'object' || result === null || typeof result.trajectories?.count !== 'number')
    throw illegal('data', 'result', result, 'a result with trajectories');
  const { width, height, numFrames, trajectories, clusters } = result;
  const { count, offset, x, y } = trajectories;
  if (offset.length !== count + 1)
    throw new TraceCutError('data', `trajectories.offset has ${offset.length} entries (expected ${count + 1})`);
  const long = Math.max(width, height);
  const [columns, rows] = [width, height].map((side) => Math.max(1, Math.round((SQUARES * side) / long)));
  const seen = new Uint8Array(Number(columns) * Number(rows));
  /** @type {number[]} */
  const speeds = [];
  const points = new Float64Array(clusters?.count ?? 0);
  for (let i = 0; i < count; i += 1) {
    const [begin, end] = [at(offset, i), at(offset, i + 1)];
    if (clusters) points[at(clusters.label, i)] = at(points, at(clusters.label, i)) + end - begin;
    for (let p = begin; p < end; p += 1) {
      seen[cell(at(y, p), height, Number(rows)) * Number(columns) + cell(at(x, p), width, Number(columns))] = 1;
      if (p > begin) speeds.push(Math.hypot(at(x, p) - at(x, p - 1), at(y, p) - at(y, p - 1)));
    }
  }
  const all = at(offset, count);
  const speed = at(Float64Array.from(speeds).sort(), speeds.length >> 1) || 0;
  return {
    numFrames,
    trajectories: count,
    coverage: seen.reduce((sum, one) => sum + one, 0) / seen.length,
    speed,
    cameraMoves: speed > STILL * long,
    motions: clusters
      ? [...points]
          .filter((one) => one > 0)
          .map((one) => one / all)
          .sort((a, b) => b - a)
      : null,
  };
}

/**
 * @param {number} place in pixels
 * @param {number} side
 * @param {number} cells
 */
function cell(place, side, cells) {
  return Math.min(cells - 1, Math.max(0, Math.floor(((place + 0.5) / side) * cells)));
}

/**
 * @param {ArrayLike<number>} values
 * @param {number} index
 */
function at(values, index) {
  return /** @type {number} */ (values[index]);
}
