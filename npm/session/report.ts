// Reports on a run from its trajectories: a track file, the search report, and the motion of the scene.

import { TraceCutError, illegal } from '../check/errors.js';
import type { ClipTrajectories } from '../video/result.js';

/**
 * Trajectories to write, as `trajectories` returns and `setTrajectories` takes them; `label` holds a label for each, 0 if
 * not given.
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
 * Formats trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
 * its label and length and, line by line, `x y frame`.
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

/** The part of a result that a search report needs: `Result`, `VideoResult`, or the like. */
export interface SearchInput {
  /** Pixels in a row. */
  width: number;
  height: number;
  numFrames: number;
  trajectories: { count: number; offset: ArrayLike<number>; x: ArrayLike<number>; y: ArrayLike<number> };
  clusters?: { count: number; label: ArrayLike<number> };
}

/**
 * Report on the area that a run covered. `coverage` is the share of the picture, 0 to 1, that trajectories crossed: of
 * squares whose side is a sixteenth of the picture's longer side, those with a trajectory in them. `speed` is the median
 * motion of the points, in pixels a frame; the camera counts as moving (`cameraMoves`) if it exceeds a thousandth of the
 * longer side. `motions` are the clusters' shares of all points, the largest first; null for a result of many windows,
 * which has no clusters.
 */
export type SearchReport = {
  readonly numFrames: number;
  readonly trajectories: number;
  readonly coverage: number;
  readonly speed: number;
  readonly cameraMoves: boolean;
  readonly motions: number[] | null;
};

/** Squares along the longer side. Chosen by eye. */
const NUM_SQUARES = 16;

/** Median motion from which the camera moves, in longer sides a frame: half a pixel at the usual working size. */
const MIN_CAMERA_MOTION = 0.001;

/** Reports on the area that a run covered, from its trajectories. */
export function searchReport(result: SearchInput): SearchReport {
  if (typeof result !== 'object' || result === null || typeof result.trajectories?.count !== 'number')
    throw illegal('data', 'result', result, 'a result with trajectories');
  const { width, height, numFrames, trajectories, clusters } = result;
  const { count, offset, x, y } = trajectories;
  if (offset.length !== count + 1)
    throw new TraceCutError('data', `trajectories.offset has ${offset.length} entries (expected ${count + 1})`);
  const longSide = Math.max(width, height);
  const countSquares = (side: number) => Math.max(1, Math.round((NUM_SQUARES * side) / longSide));
  const [columns, rows] = [countSquares(width), countSquares(height)];
  const isCovered = new Uint8Array(columns * rows);
  const speeds: number[] = [];
  const points = new Float64Array(clusters?.count ?? 0);
  for (let i = 0; i < count; i += 1) {
    const [begin, end] = [Number(offset[i]), Number(offset[i + 1])];
    if (clusters) {
      const cluster = Number(clusters.label[i]);
      points[cluster] = Number(points[cluster]) + end - begin;
    }
    for (let p = begin; p < end; p += 1) {
      const [column, row] = [toCell(Number(x[p]), width, columns), toCell(Number(y[p]), height, rows)];
      isCovered[row * columns + column] = 1;
      if (p > begin) speeds.push(Math.hypot(Number(x[p]) - Number(x[p - 1]), Number(y[p]) - Number(y[p - 1])));
    }
  }
  const numPoints = Number(offset[count]);
  const speed = Float64Array.from(speeds).sort()[speeds.length >> 1] || 0;
  return {
    numFrames,
    trajectories: count,
    coverage: isCovered.reduce((sum, value) => sum + value, 0) / isCovered.length,
    speed,
    cameraMoves: speed > MIN_CAMERA_MOTION * longSide,
    motions: clusters
      ? [...points]
          .filter((count) => count > 0)
          .map((count) => count / numPoints)
          .sort((a, b) => b - a)
      : null,
  };
}

/** @param place in pixels */
function toCell(place: number, side: number, cells: number) {
  return Math.min(cells - 1, Math.max(0, Math.floor(((place + 0.5) / side) * cells)));
}

/**
 * Trajectories with labels: a `Result`, the result of a segmented video, or your own object with such `trajectories`,
 * each with its `label`.
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
 * Position of the scene in each frame relative to the first, in pixels: a camera that pans to the right moves it to the
 * left.
 */
export type SceneMotion = { readonly x: Float64Array<ArrayBuffer>; readonly y: Float64Array<ArrayBuffer> };

/** Number of trajectories of a frame that are used: their median gets no better with more. */
const TRAJECTORIES_PER_FRAME = 400;

/**
 * Computes the motion of the scene in the picture: from frame to frame the median of the background's trajectories.
 * Rotation and zoom about the centre do not count; across a cut, or without visible background, nothing moves.
 *
 * ```js
 * const { x } = sceneMotion(result); // An object at column c of frame t is at c - x[t] of the first frame's scene.
 * ```
 */
export function sceneMotion(result: LabelledTrajectories): SceneMotion {
  const { numFrames, trajectories } = result ?? {};
  const labels = trajectories && findLabels(result);
  if (!labels || !(numFrames >= 1))
    throw illegal('data', 'result', result, 'a result with trajectories and their labels');
  const { count, startFrame, offset, x, y } = trajectories;
  const background = Array.from({ length: count }, (_, i) => i).filter((i) => labels[i] === 0);
  const points = background.reduce((sum, i) => sum + Number(offset[i + 1]) - Number(offset[i]), 0);
  const stride = Math.max(1, Math.floor(points / (numFrames * TRAJECTORIES_PER_FRAME)));
  const steps = Array.from({ length: numFrames }, () => ({
    x: [] as number[],
    y: [] as number[],
  }));
  for (let k = 0; k < background.length; k += stride) {
    const i = Number(background[k]);
    const [first, begin, end] = [Number(startFrame[i]), Number(offset[i]), Number(offset[i + 1])];
    for (let p = begin + 1; p < end; p += 1) {
      const step = steps[first + p - begin];
      step?.x.push(Number(x[p]) - Number(x[p - 1]));
      step?.y.push(Number(y[p]) - Number(y[p - 1]));
    }
  }
  return { x: accumulate(steps.map((step) => median(step.x))), y: accumulate(steps.map((step) => median(step.y))) };
}

/**
 * Returns the label of each trajectory in the masks: its own, or else the label of its cluster's object.
 * @returns undefined if no labels are known; clusters if they have no objects
 */
function findLabels({
  trajectories,
  clusters,
}: Pick<LabelledTrajectories, 'trajectories' | 'clusters'>): ArrayLike<number> | undefined {
  if (trajectories.label || !clusters?.object?.length) return trajectories.label ?? clusters?.label;
  const { label, object } = clusters;
  return Uint8Array.from(label, (cluster) => Number(object[cluster]));
}

/**
 * Returns the trajectories of masks, if any, each with the label of its object.
 * @param labelOf maps a label to its present one
 */
export function getTrajectories(
  masks: object,
  labelOf: (label: number) => number = (label) => label,
): ClipTrajectories | undefined {
  const { trajectories, clusters } = masks as Partial<LabelledTrajectories>;
  if (!trajectories) return undefined;
  const { count, startFrame, offset, x, y } = trajectories;
  const labels = findLabels({ trajectories, clusters }) ?? new Uint8Array(count);
  return { count, startFrame, offset, x, y, label: Uint8Array.from(labels, labelOf) };
}

/** @param values 0 if there are none */
function median(values: number[]) {
  const sorted = Float64Array.from(values).sort();
  const middle = sorted.length >> 1;
  if (sorted.length % 2 === 1) return Number(sorted[middle]);
  return sorted.length === 0 ? 0 : (Number(sorted[middle - 1]) + Number(sorted[middle])) / 2;
}

function accumulate(steps: number[]) {
  let sum = 0;
  return Float64Array.from(steps, (step) => (sum += step));
}

/**
 * An object: its label in the masks, its first and last frame, its number of frames, its mean area over them in pixels,
 * and its area in each frame.
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
 * The objects of a result by their labels, lowest first. Labels have gaps in later windows of a long clip and after
 * corrections.
 */
export type ObjectList = readonly VideoObject[];

/** Number of pixels of an object in each frame. */
export type ObjectAreas = { readonly label: number; readonly areas: Uint32Array<ArrayBuffer> };

/** Lists the objects that have a pixel in any frame. */
export function listObjects(objects: readonly ObjectAreas[]): ObjectList {
  return objects
    .filter(({ areas }) => areas.some((area) => area > 0))
    .sort((a, b) => a.label - b.label)
    .map(({ label, areas }) => ({ label, ...measurePresence(areas), areas }));
}

function measurePresence(areas: Uint32Array) {
  const present = [...areas.keys()].filter((t) => areas[t]);
  const sum = areas.reduce((total, area) => total + area, 0);
  return {
    firstFrame: Number(present[0]),
    lastFrame: Number(present[present.length - 1]),
    frames: present.length,
    meanArea: sum / present.length,
  };
}
