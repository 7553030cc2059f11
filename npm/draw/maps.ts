// Maps and discontinuities over a frame.

import { checkNumber, checkOptions, illegal } from '../check/errors.js';
import {
  type Context2D,
  drawOnPixelCentres,
  packColor,
  paintPixels,
  strokeSegments,
  withSavedState,
} from './canvas.js';
import { CUT_RED, flowColor, heatColor, parseColor } from './labels.js';
import { FramePoints, type TrajectorySource, toObjectFilter } from './trajectories.js';

/** The grid of a map; `scaleX` and `scaleY` are 1 if not given. */
export type MapGrid = { width: number; height: number; scaleX?: number; scaleY?: number };

/** Options of `drawBoundaries`. */
export interface DrawBoundariesOptions {
  /** Array of the map to draw; `pb` if not given. */
  of?: 'pb' | 'thin' | 'discontinuity' | 'spectral' | 'combined';
  /** Strength up to which pixels are white; 0 if not given. */
  white?: number;
  /** Strength from which pixels are black; 0.6 if not given, as stronger boundaries are rare. */
  black?: number;
}

/**
 * Draws a boundary map of a frame or of a single image: strong boundaries dark on white. The context's unit is one pixel
 * of the input, its origin the frame's upper left corner (see `fitFrame`).
 * @param map returned by `boundaries()` or `imageDiscontinuities()`
 */
export function drawBoundaries(
  context: Context2D,
  map: MapGrid & {
    pb?: Float32Array;
    thin?: Float32Array;
    discontinuity?: Float32Array;
    spectral?: Float32Array;
    combined?: Float32Array;
  },
  options: DrawBoundariesOptions = {},
) {
  const { of = 'pb', white = 0, black = 0.6 } = checkOptions(options, ['of', 'white', 'black']);
  const values = checkValues('map', map, map?.[of], `a map with ${String(of)}`);
  const span = Math.max(black - white, 1e-6);
  drawMap(context, map, (data) => {
    for (let p = 0; p < values.length; p += 1) {
      // The root makes weak boundaries visible.
      const shade = 255 * (1 - Math.sqrt(Math.min(1, Math.max(0, Number(values[p]) - white) / span)));
      data.fill(shade, 4 * p, 4 * p + 3);
      data[4 * p + 3] = 255;
    }
  });
}

/**
 * Draws a saliency map: dark for pixels that do not stand out, bright for those that do.
 * @param context as for `drawBoundaries`
 * @param map returned by `saliencyMap()`
 */
export function drawSaliency(context: Context2D, map: MapGrid & { saliency: Float32Array }) {
  const values = checkValues('map', map, map?.saliency, 'what saliencyMap() gives');
  drawMap(context, map, (data) => {
    for (let p = 0; p < values.length; p += 1) heatColor(Number(values[p]), data, 4 * p);
  });
}

/**
 * Draws a flow field: the hue is the direction, white is no motion.
 * @param context as for `drawBoundaries`
 * @param field returned by `flow()`
 * @param options `scale` is the motion drawn in full colour, in pixels; if not given, nearly the fastest of the field
 */
export function drawFlow(
  context: Context2D,
  field: MapGrid & { u: Float32Array; v: Float32Array },
  options: { scale?: number } = {},
) {
  const { scale = findFullColorSpeed(field) } = checkOptions(options, ['scale']);
  checkNumber('scale', scale, 1e-6, 1e6);
  const { u, v } = field;
  checkValues('field', field, v, 'what flow() gives');
  drawMap(context, field, (data) => {
    for (let p = 0; p < u.length; p += 1) flowColor(Number(u[p]), Number(v[p]), scale, data, 4 * p);
  });
}

/** Share of pixels slower than the speed drawn in full colour, and its minimum in pixels; chosen by eye. */
const FULL_COLOR = { share: 0.98, minSpeedPx: 0.5 };

function findFullColorSpeed(field: MapGrid & { u: Float32Array; v: Float32Array }) {
  const values = checkValues('field', field, field?.u, 'what flow() gives');
  const speeds = Float32Array.from(values, (u, p) => Math.hypot(u, Number(field.v[p]))).sort();
  return Math.max(FULL_COLOR.minSpeedPx, Number(speeds[Math.floor(FULL_COLOR.share * (speeds.length - 1))]));
}

function checkValues(name: string, map: MapGrid, values: Float32Array | undefined, expected: string) {
  if (!values || values.length !== map.width * map.height) throw illegal('data', name, map, expected);
  return values;
}

function drawMap(
  context: Context2D,
  { width, height, scaleX = 1, scaleY = 1 }: MapGrid,
  paint: (data: Uint8ClampedArray, packed: Uint32Array) => void,
) {
  withSavedState(context, () =>
    context.drawImage(paintPixels(context, width, height, paint), 0, 0, width * scaleX, height * scaleY),
  );
}

/**
 * Paints each pixel in the colour of the nearest trajectory point of frame `t`, up to some distance.
 * @param context as for `drawBoundaries`
 * @param options `color` returns `#rrggbb`, or null for cells that stay clear; `reach`, in pixels, is the distance of
 *   neighbouring points if not given
 */
export function drawCells(
  context: Context2D,
  result: TrajectorySource,
  t: number,
  options: { color: (trajectory: number) => string | null; reach?: number },
) {
  const { color, reach: givenReach } = checkOptions(options, ['color', 'reach']);
  if (typeof color !== 'function') throw illegal('param', 'color', color, 'a function of a trajectory');
  const points = new FramePoints(result, t);
  const reach = givenReach ?? points.distance();
  checkNumber('reach', reach, 0, 1e4);
  const { width, height } = result;
  drawMap(context, { width, height }, (_, pixels) => {
    const nearest = new Float32Array(width * height).fill(reach * reach);
    for (const i of points.ids) {
      const name = color(i);
      const packed = name === null ? 0 : packColor(parseColor(name));
      const pointIndex = points.index(i, t);
      const [x, y] = [Number(points.x[pointIndex]), Number(points.y[pointIndex])];
      // Cells that stay clear keep their place: neighbours must not grow into them.
      for (let py = Math.max(0, Math.ceil(y - reach)); py <= Math.min(height - 1, Math.floor(y + reach)); py += 1) {
        for (let px = Math.max(0, Math.ceil(x - reach)); px <= Math.min(width - 1, Math.floor(x + reach)); px += 1) {
          const sq = (px - x) ** 2 + (py - y) ** 2;
          const p = py * width + px;
          if (sq >= Number(nearest[p])) continue;
          nearest[p] = sq;
          pixels[p] = packed;
        }
      }
    }
  });
}

/** Pairs of trajectories, and the discontinuity between each two. */
export type EdgeEnds = { i: ArrayLike<number>; j: ArrayLike<number>; d: ArrayLike<number> };

/** The edges of frames: a result is one. */
export interface FrameEdges {
  /** Returns the edges of frame `t`. */
  edges: (t: number) => EdgeEnds;
}

/** Source of discontinuities: a result. */
export type EdgeSource = TrajectorySource & FrameEdges;

/** Options of `drawDiscontinuities`. */
export interface DrawDiscontinuitiesOptions {
  /** Discontinuity from which an edge is drawn, 0 to 1; 0.6 if not given. */
  threshold?: number;
  /** Width of a medium edge, in pixels of the input; 2 if not given. Stronger edges are wider. */
  width?: number;
  /** CSS colour; red if not given. */
  color?: string;
  /** CSS colour of edges below the threshold; faint white if not given, null for none. */
  calm?: string | null;
  /** Objects of which an edge must touch one; all if not given. */
  objects?: Iterable<number> | ((object: number) => boolean);
}

const LEGAL = ['threshold', 'width', 'color', 'calm', 'objects'];

/** Longest edge in median edge lengths: longer ones are slivers along the hull, not neighbours. Chosen by eye. */
const MAX_EDGE_LENGTHS = 6;

/** Groups of similar strength in which edges are stroked, because one stroke per edge is slow. */
const NUM_GRADES = 5;

/** Edges below the threshold, their width as a share of `width`; chosen by eye. */
const CALM = { color: 'rgb(255 255 255 / 0.14)', width: 0.3 };

/**
 * Draws the discontinuities between neighbouring trajectories of frame `t`. The context's unit is one pixel of the
 * input, its origin the frame's upper left corner (see `fitFrame`).
 */
export function drawDiscontinuities(
  context: Context2D,
  result: EdgeSource,
  t: number,
  options: DrawDiscontinuitiesOptions = {},
) {
  const { threshold = 0.6, width = 2, color = CUT_RED, calm = CALM.color, objects } = checkOptions(options, LEGAL);
  checkNumber('threshold', threshold, 0, 1);
  checkNumber('width', width, 0, 1000);
  const sorted = sortEdges(new FramePoints(result, t), result.edges(t), threshold, toObjectFilter(objects));
  drawOnPixelCentres(context, () => {
    const alpha = context.globalAlpha;
    context.lineCap = 'round';
    if (calm !== null) {
      context.strokeStyle = calm;
      context.lineWidth = CALM.width * width;
      strokeSegments(context, sorted.calm);
    }
    context.strokeStyle = color;
    sorted.cuts.forEach((pieces, grade) => {
      const strength = (grade + 0.5) / NUM_GRADES;
      context.globalAlpha = alpha * (0.45 + 0.55 * strength);
      context.lineWidth = (0.5 + strength) * width;
      strokeSegments(context, pieces);
    });
  });
}

/** Returns line segments: below the threshold, and above it by strength. */
function sortEdges(
  points: FramePoints,
  { i, j, d }: EdgeEnds,
  threshold: number,
  isSelected: (object: number) => boolean,
): { calm: number[]; cuts: number[][] } {
  const { x, y, t } = points;
  const ends = Array.from(i, (_, e) => [points.index(Number(i[e]), t), points.index(Number(j[e]), t)]);
  const lengths = ends.map(([a = -1, b = -1]) =>
    a < 0 || b < 0 ? Infinity : Math.hypot(Number(x[a]) - Number(x[b]), Number(y[a]) - Number(y[b])),
  );
  const finite = Float64Array.from(lengths.filter(Number.isFinite)).sort();
  const longest = MAX_EDGE_LENGTHS * Number(finite[finite.length >> 1] ?? 0);
  const calm: number[] = [];
  const cuts: number[][] = Array.from({ length: NUM_GRADES }, () => []);
  ends.forEach(([a = -1, b = -1], e) => {
    if (Number(lengths[e]) > longest) return;
    if (!isSelected(points.object(Number(i[e]))) && !isSelected(points.object(Number(j[e])))) return;
    const strength = (Number(d[e]) - threshold) / (1 - threshold || 1);
    const segments =
      Number(d[e]) > threshold ? cuts[Math.min(NUM_GRADES - 1, Math.floor(strength * NUM_GRADES))] : calm;
    segments?.push(Number(x[a]), Number(y[a]), Number(x[b]), Number(y[b]));
  });
  return { calm, cuts };
}
