// Objects frame by frame in numbers: where they are, how large, how they move.

import { checkedOptions, illegal } from '../check/errors.js';
import { checkMasks, chosenLabels, labelsOf, timesOf } from '../check/masks.js';

/**
 * An object in a frame, in pixels of the masks: its box, its `area` in pixels, the mean place `x`, `y` of its pixels
 * (pixel centres are at integers), and how far it moves to the next frame, `dx`, `dy`: the mean over its trajectories
 * that go on to there, whose number is `trajectories`; null where there are none, as in the last frame. `time` is that of
 * the frame in seconds, null where none is known.
 * @typedef {{frame: number, time: number | null, object: number, left: number, top: number, width: number, height:
 *   number, area: number, x: number, y: number, dx: number | null, dy: number | null, trajectories: number}} ObjectRow
 */

/**
 * Points of trajectories: those of trajectory `i` are `offset[i]` to `offset[i + 1]` of `x` and `y`, one for each of the
 * consecutive frames from `startFrame[i]` on.
 * @typedef {{startFrame: ArrayLike<number>, offset: ArrayLike<number>, x: ArrayLike<number>, y: ArrayLike<number>}}
 *   TrajectoryPoints
 */

/**
 * Options of `objectTable`.
 * @typedef {object} ObjectTableOptions
 * @property {TrajectoryPoints} [trajectories] in pixels of the masks; theirs if not given
 * @property {import('../check/masks.js').ObjectChoice} [objects] which labels are meant; all if not given
 * @property {number} [frameRate] in frames per second, where the masks have no times
 */

/** @typedef {{left: number, top: number, right: number, bottom: number, area: number, x: number, y: number, dx: number,
 * dy: number, trajectories: number}} Sums */

const LABELS = 256;
const COLUMNS = /** @type {const} */ ([
  'frame',
  'time',
  'object',
  'left',
  'top',
  'width',
  'height',
  'area',
  'x',
  'y',
  'dx',
  'dy',
  'trajectories',
]);
/** Columns with three decimals; times have six. */
const PLACES = ['x', 'y', 'dx', 'dy'];

/**
 * Where each object is in each frame, how large and how it moves: a row for each frame and object in it, by frame, then
 * by label. `JSON.stringify` and `objectTableCsv` write them.
 *
 * ```js
 * for (const { frame, object, x, y } of await objectTable(result)) console.log(frame, object, x, y);
 * ```
 * @param {import('../check/masks.js').MaskSource & {trajectories?: TrajectoryPoints}} masks
 * @param {ObjectTableOptions} [options]
 * @returns {Promise<ObjectRow[]>}
 */
export async function objectTable(masks, options = {}) {
  checkMasks(masks);
  const { trajectories, objects, frameRate } = checkedOptions(options, ['trajectories', 'objects', 'frameRate']);
  const tracks = checkedTracks(trajectories ?? masks.trajectories);
  const [chosen, times] = [chosenLabels(objects), timesOf(masks, frameRate)];
  /** @type {ObjectRow[]} */
  const rows = [];
  for (let t = 0; t < masks.numFrames; t += 1) {
    const labels = labelsOf(masks, t);
    const sums = Array.from({ length: LABELS }, nothing);
    countPixels(sums, labels, masks.width);
    if (tracks) countMotion(sums, labels, masks, tracks, t);
    sums.forEach((sum, label) => {
      if (label > 0 && chosen[label] && sum.area > 0) rows.push(rowOf(sum, t, times?.[t] ?? null, label));
    });
  }
  return rows;
}

/**
 * Rows of `objectTable` as a table of comma-separated values, with a heading; the command line writes the same as
 * `objects.csv`. Places have three decimals, what is null is left empty.
 * @param {readonly ObjectRow[]} rows
 * @returns {Promise<string>}
 */
export async function objectTableCsv(rows) {
  if (!Array.isArray(rows)) throw illegal('data', 'rows', rows, 'the rows of objectTable');
  const lines = rows.map((row) => COLUMNS.map((column) => cell(column, row[column])).join(','));
  return `${[COLUMNS.join(','), ...lines].join('\n')}\n`;
}

/**
 * @param {string} column
 * @param {number | null} value
 */
function cell(column, value) {
  if (value === null) return '';
  if (column === 'time') return String(Number(value.toFixed(6)));
  // Rounded before it is written: how ties are written differs between languages.
  return PLACES.includes(column) ? (Math.floor(value * 1000 + 0.5) / 1000).toFixed(3) : String(value);
}

/**
 * @param {unknown} tracks
 * @returns {TrajectoryPoints | null}
 */
function checkedTracks(tracks) {
  if (tracks === undefined || tracks === null) return null;
  const is = typeof tracks === 'object' && ['startFrame', 'offset', 'x', 'y'].every((name) => name in tracks);
  if (!is) throw illegal('data', 'trajectories', tracks, 'an object {startFrame, offset, x, y}');
  return /** @type {TrajectoryPoints} */ (tracks);
}

/** @returns {Sums} */
function nothing() {
  return { left: Infinity, top: Infinity, right: 0, bottom: 0, area: 0, x: 0, y: 0, dx: 0, dy: 0, trajectories: 0 };
}

/**
 * @param {Sums[]} sums
 * @param {Uint8Array} labels
 * @param {number} width
 */
function countPixels(sums, labels, width) {
  for (let p = 0; p < labels.length; p += 1) {
    const label = /** @type {number} */ (labels[p]);
    if (label === 0) continue;
    const sum = /** @type {Sums} */ (sums[label]);
    const x = p % width;
    const y = (p - x) / width;
    if (x < sum.left) sum.left = x;
    if (x > sum.right) sum.right = x;
    if (y < sum.top) sum.top = y;
    sum.bottom = y;
    sum.area += 1;
    sum.x += x;
    sum.y += y;
  }
}

/**
 * @param {Sums[]} sums
 * @param {Uint8Array} labels
 * @param {{width: number, height: number}} size
 * @param {TrajectoryPoints} tracks
 * @param {number} t
 */
function countMotion(sums, labels, { width, height }, { startFrame, offset, x, y }, t) {
  for (let i = 0; i < startFrame.length; i += 1) {
    const [begin, end] = [Number(offset[i]), Number(offset[i + 1])];
    const p = begin + t - Number(startFrame[i]);
    if (p < begin || p + 1 >= end) continue;
    const [column, row] = [pixelOf(Number(x[p]), width), pixelOf(Number(y[p]), height)];
    const sum = /** @type {Sums} */ (sums[Number(labels[row * width + column])]);
    sum.trajectories += 1;
    sum.dx += Number(x[p + 1]) - Number(x[p]);
    sum.dy += Number(y[p + 1]) - Number(y[p]);
  }
}

/**
 * The pixel that a place lies in.
 * @param {number} place
 * @param {number} side how many there are
 */
function pixelOf(place, side) {
  return Math.min(side - 1, Math.max(0, Math.floor(place + 0.5)));
}

/**
 * @param {Sums} sums
 * @param {number} frame
 * @param {number | null} time
 * @param {number} object
 * @returns {ObjectRow}
 */
function rowOf({ left, top, right, bottom, area, x, y, dx, dy, trajectories }, frame, time, object) {
  return {
    frame,
    time,
    object,
    left,
    top,
    width: right + 1 - left,
    height: bottom + 1 - top,
    area,
    x: x / area,
    y: y / area,
    dx: trajectories > 0 ? dx / trajectories : null,
    dy: trajectories > 0 ? dy / trajectories : null,
    trajectories,
  };
}
