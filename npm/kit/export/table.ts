// Objects frame by frame in numbers: their places, sizes and motion. The decoder's wasm module counts pixels and writes the
// table.

import { checkOptions, illegal } from '../../check/errors.js';
import {
  type MaskSource,
  type ObjectChoice,
  checkMasks,
  getTimes,
  readLabels,
  selectLabels,
} from '../../check/masks.js';
import { objectRows, objectTable as writeTable } from '../../decoder.js';
import { platform } from '../../platform.js';
import { callDecoder } from '../../worker/instance.js';
import type { WasmSource } from '../../check/options.js';

/**
 * An object in a frame, in pixels of the masks: its box, its `area` in pixels, the mean place `x`, `y` of its pixels
 * (pixel centres are at integers), and its motion to the next frame, `dx`, `dy`: the mean over the `trajectories` that
 * continue there; null if there are none, as in the last frame. `time` is the frame's time in seconds, null if unknown.
 * `doubt` is true if the masks of the frame should be looked at (`doubts` of a result), null if unknown.
 */
export type ObjectRow = {
  frame: number;
  time: number | null;
  object: number;
  left: number;
  top: number;
  width: number;
  height: number;
  area: number;
  x: number;
  y: number;
  dx: number | null;
  dy: number | null;
  trajectories: number;
  doubt: boolean | null;
};

/**
 * Points of trajectories: trajectory `i` has the points `offset[i]` to `offset[i + 1]` of `x` and `y`, one for each of
 * the consecutive frames from `startFrame[i]` on.
 */
export type TrajectoryPoints = {
  startFrame: ArrayLike<number>;
  offset: ArrayLike<number>;
  x: ArrayLike<number>;
  y: ArrayLike<number>;
};

/** Options of `objectTable`. */
export interface ObjectTableOptions {
  /** Trajectories in pixels of the masks; the trajectories of the masks if not given. */
  trajectories?: TrajectoryPoints;
  /** Labels to list; all but the background if not given. */
  objects?: ObjectChoice;
  /** Frames per second, if the masks have no times. */
  frameRate?: number;
  /** The file `decoder_bg.wasm`, if it is not beside the package. */
  decoder?: WasmSource;
}

/** Columns of a row, in the order of the Rust code. */
const COLUMNS = [
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
  'doubt',
] as const;

/** Most pixels of the frames that are counted at once; trajectories are passed to Rust each time. */
const MAX_PIXELS_AT_ONCE = 2 ** 25;
const LEGAL = ['trajectories', 'objects', 'frameRate', 'decoder'];

/**
 * Lists the place, size and motion of each object in each frame: a row for each frame and object in it, by frame, then by
 * label. `JSON.stringify` and `objectTableCsv` write them.
 *
 * ```js
 * for (const { frame, object, x, y } of await objectTable(result)) console.log(frame, object, x, y);
 * ```
 */
export async function objectTable(
  masks: MaskSource & { trajectories?: TrajectoryPoints },
  options: ObjectTableOptions = {},
): Promise<ObjectRow[]> {
  checkMasks(masks);
  const { trajectories, objects, frameRate, decoder } = checkOptions(options, LEGAL);
  const points = toTrackArrays(trajectories ?? masks.trajectories);
  const [selected, times] = [selectLabels(objects), getTimes(masks, frameRate)];
  const { width, height, numFrames } = masks;
  const module = await platform.loadDecoder(decoder);
  const framesAtOnce = Math.max(1, Math.floor(MAX_PIXELS_AT_ONCE / (width * height)));
  const rows: ObjectRow[] = [];
  for (let first = 0; first < numFrames; first += framesAtOnce) {
    const frames = Math.min(framesAtOnce, numFrames - first);
    const labels = new Uint8Array(frames * width * height);
    for (let k = 0; k < frames; k += 1) labels.set(readLabels(masks, first + k), k * width * height);
    const numbers = await call(module, () => objectRows(labels, width, height, first, ...points));
    for (let offset = 0; offset < numbers.length; offset += COLUMNS.length) {
      const row = toRow(numbers.subarray(offset, offset + COLUMNS.length));
      const { frame } = row;
      const doubt = masks.doubts ? masks.doubts.some(({ from, to }) => from <= frame && frame < to) : null;
      if (selected[row.object]) rows.push({ ...row, time: times?.[frame] ?? null, doubt });
    }
  }
  return rows;
}

/**
 * Formats rows of `objectTable` as comma-separated values with a header, the same as `objects.csv` of the command line.
 * Places have three decimals, null is an empty field.
 * @param options `decoder` is the file `decoder_bg.wasm`, if it is not beside the package
 */
export async function objectTableCsv(
  rows: readonly ObjectRow[],
  options: { decoder?: WasmSource } = {},
): Promise<string> {
  const { decoder } = checkOptions(options, ['decoder']);
  if (!Array.isArray(rows)) throw illegal('data', 'rows', rows, 'the rows of objectTable');
  const numbers = rows.flatMap((row) => COLUMNS.map((column) => row[column] ?? NaN));
  return call(await platform.loadDecoder(decoder), () => writeTable(Float64Array.from(numbers)));
}

function call<T>(module: WebAssembly.Module, work: () => T) {
  return callDecoder(module, work, 'the table cannot be made');
}

/** Converts trajectories to arrays for Rust, empty ones if none are given. */
function toTrackArrays(tracks: unknown): [Uint32Array, Uint32Array, Float32Array, Float32Array] {
  if (tracks === undefined || tracks === null)
    return [new Uint32Array(), new Uint32Array(1), new Float32Array(), new Float32Array()];
  const isValid = typeof tracks === 'object' && ['startFrame', 'offset', 'x', 'y'].every((name) => name in tracks);
  if (!isValid) throw illegal('data', 'trajectories', tracks, 'an object {startFrame, offset, x, y}');
  const { startFrame, offset, x, y } = tracks as TrajectoryPoints;
  return [Uint32Array.from(startFrame), Uint32Array.from(offset), Float32Array.from(x), Float32Array.from(y)];
}

/** @param numbers NaN for null */
function toRow(numbers: Float64Array): ObjectRow {
  const entries = COLUMNS.map((column, k) => [column, Number.isNaN(numbers[k]) ? null : numbers[k]]);
  return Object.fromEntries(entries);
}
