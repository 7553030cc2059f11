// Point trajectories on a canvas: their places in a frame, and the last part of their paths.

import { checkFlag, checkNumber, checkOptions, checkWholeNumber, illegal } from '../check/errors.js';
import { MAX_LABEL } from '../check/masks.js';
import { type Context2D, drawOnPixelCentres } from './canvas.js';
import { type Shape, objectColor, objectShape } from './labels.js';

/**
 * Source of trajectories to draw: a result of a session, of a window or of a whole video, or the part of one that is
 * used. The object of a trajectory is `trajectories.label`, or else the object of its cluster, numbered as in the masks;
 * without masks each cluster counts as an object.
 */
export interface TrajectorySource {
  /** Pixels in a row. */
  width: number;
  /** Number of rows. */
  height: number;
  numFrames: number;
  trajectories: {
    count: number;
    startFrame: ArrayLike<number>;
    offset: ArrayLike<number>;
    x: ArrayLike<number>;
    y: ArrayLike<number>;
    label?: ArrayLike<number>;
  };
  clusters?: { label: ArrayLike<number>; object?: ArrayLike<number> | null };
}

/** Options of `drawTrajectories`. */
export interface DrawTrajectoriesOptions {
  /** Frames of its path drawn behind a point; 8 if not given. */
  tail?: number;
  /** Width of the tail, in pixels of the input; 1.5 if not given. */
  width?: number;
  /** Radius of the points, in pixels of the input; by their distance if not given. */
  radius?: number;
  /** Draws a dark border that keeps points legible on bright footage; true if not given. */
  outline?: boolean;
  /**
   * Colour by object, with a smaller and fainter background, if not given; by cluster; one CSS colour; or a CSS colour
   * for each trajectory.
   */
  color?: 'object' | 'cluster' | string | ((trajectory: number) => string);
  /** Shape of the points; if not given, the label's with `color` by object or cluster, else discs. */
  shape?: Shape | ((trajectory: number) => Shape);
  /** Objects whose trajectories are drawn; all, and the background, if not given. */
  objects?: Iterable<number> | ((object: number) => boolean);
  /** Further filter on trajectories. */
  which?: (trajectory: number) => boolean;
}

/** Trajectories drawn in the same style. */
type StyleGroup = { color: string; shape: Shape; muted: boolean; ids: number[] };

const LEGAL = ['tail', 'width', 'radius', 'outline', 'color', 'shape', 'objects', 'which'];

/** Border of points; its width as a share of the tail's, chosen by eye. */
const POINT_BORDER = { color: 'rgb(0 0 0 / 0.5)', share: 0.4 };

/** Radius, tail width and opacity of the background as shares of an object's, so that objects stand out; by eye. */
const MUTED = { radius: 0.5, width: 0.55, strength: 0.45 };

/** Opacity of a tail at its point; chosen by eye. */
const TAIL_OPACITY = 0.9;

/** Radius of a point as a share of the distance between points, and its minimum in pixels of the input; by eye. */
const RADIUS = { share: 0.17, minPx: 1 };

/**
 * Draws the trajectories that are alive in frame `t`. The context's unit is one pixel of the input, its origin the
 * frame's upper left corner (see `fitFrame`).
 */
export function drawTrajectories(
  context: Context2D,
  result: TrajectorySource,
  t: number,
  options: DrawTrajectoriesOptions = {},
) {
  const { tail = 8, width = 1.5, outline = true } = checkOptions(options, LEGAL);
  checkWholeNumber('param', 'tail', tail, 0, 1_000_000);
  checkNumber('width', width, 0, 1000);
  checkFlag('outline', outline);
  const points = new FramePoints(result, t);
  const { radius = Math.max(RADIUS.minPx, RADIUS.share * points.distance()) } = options;
  checkNumber('radius', radius, 0, 1000);
  const groups = groupByStyle(points, options);
  drawOnPixelCentres(context, () => {
    context.lineCap = 'round';
    for (const group of groups) drawTails(context, points, group, width, tail);
    for (const { ids, shape, color, muted } of groups) {
      const groupRadius = muted ? MUTED.radius * radius : radius;
      if (outline)
        fillPoints(context, points, ids, shape, POINT_BORDER.color, groupRadius + POINT_BORDER.share * width);
      fillPoints(context, points, ids, shape, color, groupRadius);
    }
  });
}

/** The trajectories visible in a frame. */
export class FramePoints {
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  ids: number[];

  constructor(
    public result: TrajectorySource,
    readonly t: number,
  ) {
    if (
      typeof result !== 'object' ||
      result === null ||
      typeof result.trajectories?.count !== 'number' ||
      !(result.clusters ?? result.trajectories.label)
    ) {
      throw illegal(
        'data',
        'result',
        result,
        'a result, or an object {width, height, numFrames, trajectories, clusters, objects}',
      );
    }
    checkWholeNumber('param', 't', t, 0, result.numFrames - 1);
    this.x = result.trajectories.x;
    this.y = result.trajectories.y;
    this.ids = [];
    for (let i = 0; i < result.trajectories.count; i += 1) if (this.index(i, t) >= 0) this.ids.push(i);
  }

  /** Returns the index of a trajectory's point of frame `t` in `x` and `y`; -1 if it is not visible then. */
  index(i: number, t: number) {
    const { startFrame, offset } = this.result.trajectories;
    const age = t - Number(startFrame[i]);
    return age >= 0 && age < Number(offset[i + 1]) - Number(offset[i]) ? Number(offset[i]) + age : -1;
  }

  /** Returns the object of a trajectory. */
  object(i: number) {
    const { clusters, trajectories } = this.result;
    if (trajectories.label) return Number(trajectories.label[i]);
    const cluster = this.cluster(i);
    return clusters?.object?.length ? Number(clusters.object[cluster]) : cluster;
  }

  /** Returns the cluster of a trajectory, or its object if no clusters are known. */
  cluster(i: number) {
    const { clusters, trajectories } = this.result;
    return Number((clusters ?? trajectories).label?.[i]);
  }

  /** Estimates the distance between points, in pixels. */
  distance() {
    return Math.sqrt((this.result.width * this.result.height) / Math.max(1, this.ids.length));
  }
}

/** Groups trajectories by style: the background first, then by object. */
function groupByStyle(
  points: FramePoints,
  { color = 'object', shape, objects, which }: DrawTrajectoriesOptions,
): StyleGroup[] {
  if (typeof color !== 'string' && typeof color !== 'function')
    throw illegal('param', 'color', color, "'object', 'cluster', a CSS colour, or a function of a trajectory");
  const isSelected = toObjectFilter(objects);
  const label = color === 'cluster' ? (i: number) => points.cluster(i) : (i: number) => points.object(i);
  const isByLabel = color === 'object' || color === 'cluster';
  const getColor = isByLabel
    ? (i: number) => objectColor(toPaletteLabel(label(i)))
    : typeof color === 'function'
      ? color
      : () => color;
  const getShape =
    typeof shape === 'function'
      ? shape
      : (i: number) => shape ?? (isByLabel ? objectShape(toPaletteLabel(label(i))) : 'disc');
  const groups = new Map<string, StyleGroup & { first: number }>();
  for (const i of points.ids) {
    if (!isSelected(points.object(i)) || (which && !which(i))) continue;
    const style = { color: getColor(i), shape: getShape(i), muted: isByLabel && label(i) === 0 };
    const key = `${style.color} ${style.shape} ${style.muted}`;
    const group = groups.get(key) ?? { ...style, first: label(i), ids: [] };
    groups.set(key, group);
    group.ids.push(i);
  }
  return [...groups.values()].sort((a, b) => a.first - b.first);
}

export function toObjectFilter(
  objects: Iterable<number> | ((object: number) => boolean) | undefined,
): (object: number) => boolean {
  if (objects === undefined) return () => true;
  if (typeof objects === 'function') return objects;
  if (typeof objects !== 'object' || objects === null || !(Symbol.iterator in objects)) {
    throw illegal('param', 'objects', objects, 'a list of objects, or a function of one');
  }
  const selected = new Set(objects);
  return (object) => selected.has(object);
}

/** Maps a cluster to a label of the palette: there may be more clusters than colours. */
function toPaletteLabel(label: number) {
  return label <= MAX_LABEL ? label : 1 + ((label - 1) % MAX_LABEL);
}

function drawTails(
  context: Context2D,
  points: FramePoints,
  { ids, color, muted }: StyleGroup,
  width: number,
  tail: number,
) {
  const { x, y, t } = points;
  const alpha = context.globalAlpha;
  context.strokeStyle = color;
  context.lineWidth = muted ? MUTED.width * width : width;
  // One path per age: each step back in time is a little fainter.
  for (let back = Math.min(tail, t); back >= 1; back -= 1) {
    context.globalAlpha = alpha * (muted ? MUTED.strength : TAIL_OPACITY) * (1 - back / (tail + 1));
    context.beginPath();
    for (const i of ids) {
      const start = points.index(i, t - back);
      if (start < 0) continue;
      context.moveTo(Number(x[start]), Number(y[start]));
      context.lineTo(Number(x[start + 1]), Number(y[start + 1]));
    }
    context.stroke();
  }
  context.globalAlpha = alpha;
}

function fillPoints(
  context: Context2D,
  points: FramePoints,
  ids: number[],
  shape: Shape,
  color: string,
  radius: number,
) {
  context.fillStyle = color;
  context.beginPath();
  for (const i of ids) {
    const pointIndex = points.index(i, points.t);
    const [x, y] = [Number(points.x[pointIndex]), Number(points.y[pointIndex])];
    if (shape === 'square') {
      context.rect(x - radius, y - radius, 2 * radius, 2 * radius);
    } else if (shape === 'diamond') {
      addDiamond(context, x, y, 1.3 * radius);
    } else {
      context.moveTo(x + radius, y);
      context.arc(x, y, radius, 0, 2 * Math.PI);
    }
  }
  context.fill();
}

function addDiamond(context: Context2D, x: number, y: number, radius: number) {
  context.moveTo(x, y - radius);
  context.lineTo(x + radius, y);
  context.lineTo(x, y + radius);
  context.lineTo(x - radius, y);
  context.closePath();
}
