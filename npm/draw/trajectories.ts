// Point trajectories on a canvas: where they are in a frame, and the last part of the way that they came.

import { checkFlag, checkNumber, checkedOptions, illegal, wholeNumber } from '../check/errors.js';
import { MAX_LABEL } from '../check/masks.js';
import { type Context2D, onPixelCentres } from './canvas.js';
import { type Shape, objectColor, objectShape } from './palette.js';

/**
 * What trajectories are drawn of: a result of a session, of a window or of a whole video, or the part of one that it
 * takes. The object of a trajectory is `trajectories.label` or else that of its cluster, numbered as in the masks;
 * without masks each cluster is taken for an object.
 */
export interface TrajectorySource {
  /** In pixels. */
  width: number;
  /** In pixels. */
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

export interface DrawTrajectoriesOptions {
  /** How many frames of its way are shown behind a point; 8 if not given. */
  tail?: number;
  /** Of the tail, in pixels of the input; 1.5 if not given. */
  width?: number;
  /** Of the points, in pixels of the input; by their distance if not given. */
  radius?: number;
  /** A dark rim that keeps points legible on bright footage; true if not given. */
  rim?: boolean;
  /**
   * By object, with the background smaller and fainter, if not given; by cluster; a CSS colour for all, or of each
   * trajectory.
   */
  color?: 'object' | 'cluster' | string | ((trajectory: number) => string);
  /** Of the points; with `color` by object or cluster their own, else discs, if not given. */
  shape?: Shape | ((trajectory: number) => Shape);
  /** Whose trajectories are drawn; all, the background's too, if not given. */
  objects?: Iterable<number> | ((object: number) => boolean);
  /** Leaves out others. */
  which?: (trajectory: number) => boolean;
}

/** Trajectories that look alike. */
export type Group = { color: string; shape: Shape; muted: boolean; ids: number[] };

const LEGAL = ['tail', 'width', 'radius', 'rim', 'color', 'shape', 'objects', 'which'];

/** The rim, and how far it goes beyond the point against the tail's width. */
const RIM = { color: 'rgb(0 0 0 / 0.5)', share: 0.4 };

/** The background's points and tails, so that objects stand out. */
const MUTED = { radius: 0.5, width: 0.55, strength: 0.45 };

/** Opacity of a tail where it meets its point. */
const STRENGTH = 0.9;

/** Radius of a point against the distance between points, and the least in pixels of the input. */
const RADIUS = { share: 0.17, least: 1 };

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
  const { tail = 8, width = 1.5, rim = true } = checkedOptions(options, LEGAL);
  wholeNumber('param', 'tail', tail, 0, 1_000_000);
  checkNumber('width', width, 0, 1000);
  checkFlag('rim', rim);
  const points = new FramePoints(result, t);
  const { radius = Math.max(RADIUS.least, RADIUS.share * points.distance()) } = options;
  checkNumber('radius', radius, 0, 1000);
  const groups = grouped(points, options);
  onPixelCentres(context, () => {
    context.lineCap = 'round';
    for (const group of groups) drawTails(context, points, group, width, tail);
    for (const { ids, shape, color, muted } of groups) {
      const own = muted ? MUTED.radius * radius : radius;
      if (rim) fillPoints(context, points, ids, shape, RIM.color, own + RIM.share * width);
      fillPoints(context, points, ids, shape, color, own);
    }
  });
}

/** The trajectories alive in a frame. */
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
    wholeNumber('param', 't', t, 0, result.numFrames - 1);
    this.x = result.trajectories.x;
    this.y = result.trajectories.y;
    this.ids = [];
    for (let i = 0; i < result.trajectories.count; i += 1) if (this.index(i, t) >= 0) this.ids.push(i);
  }

  /** The place of a trajectory's point of frame `t` in `x` and `y`; -1 where it is not alive. */
  index(i: number, t: number) {
    const { startFrame, offset } = this.result.trajectories;
    const age = t - Number(startFrame[i]);
    return age >= 0 && age < Number(offset[i + 1]) - Number(offset[i]) ? Number(offset[i]) + age : -1;
  }

  /** The object that a trajectory belongs to. */
  object(i: number) {
    const { clusters, trajectories } = this.result;
    if (trajectories.label) return Number(trajectories.label[i]);
    const cluster = this.cluster(i);
    return clusters?.object ? Number(clusters.object[cluster]) : cluster;
  }

  /** The cluster that a trajectory belongs to; its object where no clusters are known. */
  cluster(i: number) {
    const { clusters, trajectories } = this.result;
    return Number((clusters ?? trajectories).label?.[i]);
  }

  /** How far points lie apart, about, in pixels. */
  distance() {
    return Math.sqrt((this.result.width * this.result.height) / Math.max(1, this.ids.length));
  }
}

/** Returns trajectories in groups: those of the background first, then by object. */
function grouped(points: FramePoints, { color = 'object', shape, objects, which }: DrawTrajectoriesOptions): Group[] {
  if (typeof color !== 'string' && typeof color !== 'function')
    throw illegal('param', 'color', color, "'object', 'cluster', a CSS colour, or a function of a trajectory");
  const shown = choice(objects);
  const label = color === 'cluster' ? (i: number) => points.cluster(i) : (i: number) => points.object(i);
  const own = color === 'object' || color === 'cluster';
  const colorOf = own
    ? (i: number) => objectColor(inPalette(label(i)))
    : typeof color === 'function'
      ? color
      : () => color;
  const shapeOf =
    typeof shape === 'function' ? shape : (i: number) => shape ?? (own ? objectShape(inPalette(label(i))) : 'disc');
  const groups = new Map<string, Group & { first: number }>();
  for (const i of points.ids) {
    if (!shown(points.object(i)) || (which && !which(i))) continue;
    const style = { color: colorOf(i), shape: shapeOf(i), muted: own && label(i) === 0 };
    const key = `${style.color} ${style.shape} ${style.muted}`;
    const known = groups.get(key) ?? { ...style, first: label(i), ids: [] };
    groups.set(key, known);
    known.ids.push(i);
  }
  return [...groups.values()].sort((a, b) => a.first - b.first);
}

export function choice(
  objects: Iterable<number> | ((object: number) => boolean) | undefined,
): (object: number) => boolean {
  if (objects === undefined) return () => true;
  if (typeof objects === 'function') return objects;
  if (typeof objects !== 'object' || objects === null || !(Symbol.iterator in objects)) {
    throw illegal('param', 'objects', objects, 'a list of objects, or a function of one');
  }
  const chosen = new Set(objects);
  return (object) => chosen.has(object);
}

/** There may be more clusters than colours. */
function inPalette(label: number) {
  return label <= MAX_LABEL ? label : 1 + ((label - 1) % MAX_LABEL);
}

function drawTails(context: Context2D, points: FramePoints, { ids, color, muted }: Group, width: number, tail: number) {
  const { x, y, t } = points;
  const alpha = context.globalAlpha;
  context.strokeStyle = color;
  context.lineWidth = muted ? MUTED.width * width : width;
  // One path per age: each step back in time is a little fainter.
  for (let back = Math.min(tail, t); back >= 1; back -= 1) {
    context.globalAlpha = alpha * (muted ? MUTED.strength : STRENGTH) * (1 - back / (tail + 1));
    context.beginPath();
    for (const i of ids) {
      const from = points.index(i, t - back);
      if (from < 0) continue;
      context.moveTo(Number(x[from]), Number(y[from]));
      context.lineTo(Number(x[from + 1]), Number(y[from + 1]));
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
    const at = points.index(i, points.t);
    const [x, y] = [Number(points.x[at]), Number(points.y[at])];
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
