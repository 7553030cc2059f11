// Objects frame by frame in numbers: where they are, how large, how they move. Rust counts, and writes the table, in the module
// that reads files too.

import { checkedOptions, illegal } from '../../check/errors.js';
import { type MaskSource, type ObjectChoice, checkMasks, chosenLabels, labelsOf, timesOf } from '../../check/masks.js';
import { objectTable as writeTable, objectRows } from '../../decoder.js';
import { platform } from '../../platform.js';
import { callDecoder } from '../../worker/decode.js';
import type { WasmSource } from '../../check/options.js';

/**
 * An object in a frame, in pixels of the masks: its box, its `area` in pixels, the mean place `x`, `y` of its pixels
 * (pixel centres are at integers), and how far it moves to the next frame, `dx`, `dy`: the mean over its trajectories
 * that go on to there, whose number is `trajectories`; null where there are none, as in the last frame. `time` is that of
 * the frame in seconds, null where none is known.
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
};

/**
 * Points of trajectories: those of trajectory `i` are `offset[i]` to `offset[i + 1]` of `x` and `y`, one for each of the
 * consecutive frames from `startFrame[i]` on.
 */
export type TrajectoryPoints = {
  startFrame: ArrayLike<number>;
  offset: ArrayLike<number>;
  x: ArrayLike<number>;
  y: ArrayLike<number>;
};

/** Options of `objectTable`. */
export interface ObjectTableOptions {
  /** In pixels of the masks; theirs if not given. */
  trajectories?: TrajectoryPoints;
  /** Which labels are meant; all if not given. */
  objects?: ObjectChoice;
  /** In frames per second, where the masks have no times. */
  frameRate?: number;
  /** Where `decoder_bg.wasm` is, when not beside the package. */
  decoder?: WasmSource;
}

/** What a row is, in the order in which Rust has it. */
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
] as const;

/** Pixels of the frames that are counted at once: trajectories cross to Rust each time. */
const MOST_PIXELS = 2 ** 25;
const LEGAL = ['trajectories', 'objects', 'frameRate', 'decoder'];

/**
 * Where each object is in each frame, how large and how it moves: a row for each frame and object in it, by frame, then
 * by label. `JSON.stringify` and `objectTableCsv` write them.
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
  const { trajectories, objects, frameRate, decoder } = checkedOptions(options, LEGAL);
  const points = checkedTracks(trajectories ?? masks.trajectories);
  const [chosen, times] = [chosenLabels(objects), timesOf(masks, frameRate)];
  const { width, height, numFrames } = masks;
  const module = await platform.loadDecoder(decoder);
  const atOnce = Math.max(1, Math.floor(MOST_PIXELS / (width * height)));
  const rows: ObjectRow[] = [];
  for (let first = 0; first < numFrames; first += atOnce) {
    const frames = Math.min(atOnce, numFrames - first);
    const labels = new Uint8Array(frames * width * height);
    for (let k = 0; k < frames; k += 1) labels.set(labelsOf(masks, first + k), k * width * height);
    const numbers = await call(module, () => objectRows(labels, width, height, first, ...points));
    for (let at = 0; at < numbers.length; at += COLUMNS.length) {
      const row = rowOf(numbers.subarray(at, at + COLUMNS.length));
      if (chosen[row.object]) rows.push({ ...row, time: times?.[row.frame] ?? null });
    }
  }
  return rows;
}

/**
 * Rows of `objectTable` as a table of comma-separated values, with a heading; the command line writes the same as
 * `objects.csv`. Places have three decimals, what is null is left empty.
 * @param options `decoder` says where `decoder_bg.wasm` is, when not beside the package
 */
export async function objectTableCsv(
  rows: readonly ObjectRow[],
  options: { decoder?: WasmSource } = {},
): Promise<string> {
  const { decoder } = checkedOptions(options, ['decoder']);
  if (!Array.isArray(rows)) throw illegal('data', 'rows', rows, 'the rows of objectTable');
  const numbers = rows.flatMap((row) => COLUMNS.map((column) => row[column] ?? NaN));
  return call(await platform.loadDecoder(decoder), () => writeTable(Float64Array.from(numbers)));
}

function call<T>(module: WebAssembly.Module, work: () => T) {
  return callDecoder(module, work, 'the table cannot be made');
}

/** What Rust takes of trajectories: all of none, where none are given. */
function checkedTracks(tracks: unknown): [Uint32Array, Uint32Array, Float32Array, Float32Array] {
  if (tracks === undefined || tracks === null)
    return [new Uint32Array(), new Uint32Array(1), new Float32Array(), new Float32Array()];
  const is = typeof tracks === 'object' && ['startFrame', 'offset', 'x', 'y'].every((name) => name in tracks);
  if (!is) throw illegal('data', 'trajectories', tracks, 'an object {startFrame, offset, x, y}');
  const { startFrame, offset, x, y } = tracks as TrajectoryPoints;
  return [Uint32Array.from(startFrame), Uint32Array.from(offset), Float32Array.from(x), Float32Array.from(y)];
}

/** @param numbers NaN where there is none */
function rowOf(numbers: Float64Array): ObjectRow {
  const named = COLUMNS.map((column, k) => [column, Number.isNaN(numbers[k]) ? null : numbers[k]]);
  return Object.fromEntries(named);
}
