// What is said of a run by its trajectories: as a track file, where it looked, and how the scene moves in the picture.

import { illegal, TraceCutError } from '../check/errors.js';
import type { ClipTrajectories } from '../video/result.js';

/**
 * Trajectories to write, as `trajectories` gives them and `setTrajectories` takes them; `label` holds a label for each,
 * 0 if not given.
 */
export interface TracksToWrite {
  numFrames: number;
  startFrame: Uint32Array | readonly number[];
  offset: Uint32Array | readonly number[];
  x: Float32Array | Float64Array | readonly number[];
  y: Float32Array | Float64Array | readonly number[];
  label?: ArrayLike<number>;
}

/**
 * Trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track its label
 * and length and, line by line, `x y frame`.
 */
export function tracksDat({ numFrames, startFrame, offset, x, y, label }: TracksToWrite): string {
  const lines = [`${numFrames}`, `${startFrame.length}`];
  for (let i = 0; i < startFrame.length; i += 1) {
    const [begin, end, start] = [Number(offset[i]), Number(offset[i + 1]), Number(startFrame[i])];
    lines.push(`${label?.[i] ?? 0} ${end - begin}`);
    for (let p = begin; p < end; p += 1)
      lines.push(`${Number(x[p]).toFixed(3)} ${Number(y[p]).toFixed(3)} ${start + p - begin}`);
  }
  return `${lines.join('\n')}\n`;
}

/** What a report needs of a result: `Result`, `VideoResult`, or the like. */
export interface Searched {
  /** In pixels. */
  width: number;
  height: number;
  numFrames: number;
  trajectories: { count: number; offset: ArrayLike<number>; x: ArrayLike<number>; y: ArrayLike<number> };
  clusters?: { count: number; label: ArrayLike<number> };
}

/**
 * Where a run looked. `coverage` is the part of the picture, 0 to 1, that trajectories went over: of squares whose side
 * is a sixteenth of the longer side of the picture, those that a trajectory was in. `speed` is the median motion of
 * their points, in pixels a frame; the camera counts as moving (`cameraMoves`) where that is above a thousandth of the
 * longer side. `motions` are the parts of all points that each cluster holds, the largest first; null for a result of
 * many windows, which has no clusters.
 */
export type SearchReport = {
  readonly numFrames: number;
  readonly trajectories: number;
  readonly coverage: number;
  readonly speed: number;
  readonly cameraMoves: boolean;
  readonly motions: number[] | null;
};

/** Squares along the longer side. */
const SQUARES = 16;

/** Motion that is the camera's, in longer sides a frame: half a pixel at the usual working size. */
const STILL = 0.001;

/** Where a run looked, from its trajectories. */
export function searchReport(result: Searched): SearchReport {
  if (typeof result !== 'object' || result === null || typeof result.trajectories?.count !== 'number')
    throw illegal('data', 'result', result, 'a result with trajectories');
  const { width, height, numFrames, trajectories, clusters } = result;
  const { count, offset, x, y } = trajectories;
  if (offset.length !== count + 1)
    throw new TraceCutError('data', `trajectories.offset has ${offset.length} entries (expected ${count + 1})`);
  const long = Math.max(width, height);
  const squares = (side: number) => Math.max(1, Math.round((SQUARES * side) / long));
  const [columns, rows] = [squares(width), squares(height)];
  const seen = new Uint8Array(columns * rows);
  const speeds: number[] = [];
  const points = new Float64Array(clusters?.count ?? 0);
  for (let i = 0; i < count; i += 1) {
    const [begin, end] = [Number(offset[i]), Number(offset[i + 1])];
    if (clusters) {
      const cluster = Number(clusters.label[i]);
      points[cluster] = Number(points[cluster]) + end - begin;
    }
    for (let p = begin; p < end; p += 1) {
      const [column, row] = [cell(Number(x[p]), width, columns), cell(Number(y[p]), height, rows)];
      seen[row * columns + column] = 1;
      if (p > begin) speeds.push(Math.hypot(Number(x[p]) - Number(x[p - 1]), Number(y[p]) - Number(y[p - 1])));
    }
  }
  const all = Number(offset[count]);
  const speed = Float64Array.from(speeds).sort()[speeds.length >> 1] || 0;
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

/** @param place in pixels */
function cell(place: number, side: number, cells: number) {
  return Math.min(cells - 1, Math.max(0, Math.floor(((place + 0.5) / side) * cells)));
}

/**
 * Trajectories whose labels are known: a `Result`, the result of a segmented video, or an object of the caller's with
 * `trajectories` as theirs, each with its `label`.
 */
export interface LabelledTrajectories {
  numFrames: number;
  trajectories: {
    count: number;
    startFrame: Uint32Array;
    offset: Uint32Array;
    x: Float32Array;
    y: Float32Array;
    label?: ArrayLike<number>;
  };
  clusters?: { label: ArrayLike<number>; object?: ArrayLike<number> | null };
}

/**
 * Where the scene lies in each frame as against the first, in pixels: a camera that pans to the right moves it to the
 * left.
 */
export type SceneMotion = { readonly x: Float64Array<ArrayBuffer>; readonly y: Float64Array<ArrayBuffer> };

/** Trajectories of a frame that are listened to: their median is no better with more. */
const ENOUGH = 400;

/**
 * How far the scene has moved in the picture: from frame to frame the median of the background's trajectories. Turning
 * and zooming about the middle are no such motion; across a cut, or where no background is seen, nothing moves.
 *
 * ```js
 * const { x } = sceneMotion(result); // An object at column c of frame t is at c - x[t] of the first frame's scene.
 * ```
 */
export function sceneMotion(result: LabelledTrajectories): SceneMotion {
  const { numFrames, trajectories } = result ?? {};
  const known = trajectories && objectLabels(result);
  if (!known || !(numFrames >= 1))
    throw illegal('data', 'result', result, 'a result with trajectories and their labels');
  const { count, startFrame, offset, x, y } = trajectories;
  const scene = Array.from({ length: count }, (_, i) => i).filter((i) => known[i] === 0);
  const points = scene.reduce((sum, i) => sum + Number(offset[i + 1]) - Number(offset[i]), 0);
  const every = Math.max(1, Math.floor(points / (numFrames * ENOUGH)));
  const steps = Array.from({ length: numFrames }, () => ({
    x: [] as number[],
    y: [] as number[],
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

/**
 * Returns the label of each trajectory in the masks: that of its cluster's object, where it has none of its own.
 * @returns undefined where no labels are known; of clusters where these have no objects
 */
function objectLabels({
  trajectories,
  clusters,
}: Pick<LabelledTrajectories, 'trajectories' | 'clusters'>): ArrayLike<number> | undefined {
  if (trajectories.label || !clusters?.object) return trajectories.label ?? clusters?.label;
  const { label, object } = clusters;
  return Uint8Array.from(label, (cluster) => Number(object[cluster]));
}

/**
 * Returns the trajectories of masks, where they have some, each with the label of its object.
 * @param labelOf gives what a label is called now
 */
export function clipTrajectories(
  masks: object,
  labelOf: (label: number) => number = (label) => label,
): ClipTrajectories | undefined {
  const { trajectories, clusters } = masks as Partial<LabelledTrajectories>;
  if (!trajectories) return undefined;
  const { count, startFrame, offset, x, y } = trajectories;
  const known = objectLabels({ trajectories, clusters }) ?? new Uint8Array(count);
  return { count, startFrame, offset, x, y, label: Uint8Array.from(known, labelOf) };
}

/** @param values 0 where there are none */
function median(values: number[]) {
  const sorted = Float64Array.from(values).sort();
  const middle = sorted.length >> 1;
  if (sorted.length % 2 === 1) return Number(sorted[middle]);
  return sorted.length === 0 ? 0 : (Number(sorted[middle - 1]) + Number(sorted[middle])) / 2;
}

function summed(steps: number[]) {
  let sum = 0;
  return Float64Array.from(steps, (step) => (sum += step));
}

/**
 * An object: its label in the masks, the first and last frame it is in, the number of frames it is in, its mean area over
 * these in pixels, and its area in each frame.
 */
export type VideoObject = {
  readonly label: number;
  readonly firstFrame: number;
  readonly lastFrame: number;
  readonly frames: number;
  readonly meanArea: number;
  readonly areas: Uint32Array<ArrayBuffer>;
};

/**
 * The objects of a result, one each, by their labels, lowest first: `length` is their number. Labels have gaps in later
 * windows of a long clip and after corrections.
 */
export type ObjectList = readonly VideoObject[];

/** The pixels of an object in each frame. */
export type Areas = { readonly label: number; readonly areas: Uint32Array<ArrayBuffer> };

/** Lists the objects that have a pixel in some frame. */
export function objectList(objects: readonly Areas[]): ObjectList {
  return objects
    .filter(({ areas }) => areas.some((area) => area > 0))
    .sort((a, b) => a.label - b.label)
    .map(({ label, areas }) => ({ label, ...presence(areas), areas }));
}

function presence(areas: Uint32Array) {
  const present = [...areas.keys()].filter((t) => areas[t]);
  const sum = areas.reduce((total, area) => total + area, 0);
  return {
    firstFrame: Number(present[0]),
    lastFrame: Number(present[present.length - 1]),
    frames: present.length,
    meanArea: sum / present.length,
  };
}
