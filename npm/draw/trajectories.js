// Point trajectories on a canvas: where they are in a frame, and the last part of the way that they came.

import { checkFlag, checkNumber, checkedOptions, illegal, wholeNumber } from '../check/errors.js';
import { MAX_LABEL } from '../check/masks.js';
import { onPixelCentres } from './canvas.js';
import { objectColor, objectShape } from './palette.js';

/**
 * What trajectories are drawn of: a result of a session, of a window or of a whole video, or the part of one that it
 * takes. The object of a trajectory is `trajectories.label` or else that of its cluster, numbered as in the masks;
 * without masks each cluster is taken for an object.
 * @typedef {object} TrajectorySource
 * @property {number} width in pixels
 * @property {number} height in pixels
 * @property {number} numFrames
 * @property {{count: number, startFrame: ArrayLike<number>, offset: ArrayLike<number>, x: ArrayLike<number>, y:
 *   ArrayLike<number>, label?: ArrayLike<number>}} trajectories
 * @property {{label: ArrayLike<number>, object?: ArrayLike<number> | null}} [clusters]
 */

/**
 * @typedef {object} DrawTrajectoriesOptions
 * @property {number} [tail] how many frames of its way are shown behind a point; 8 if not given
 * @property {number} [width] of the tail, in pixels of the input; 1.5 if not given
 * @property {number} [radius] of the points, in pixels of the input; by their distance if not given
 * @property {boolean} [rim] a dark rim that keeps points legible on bright footage; true if not given
 * @property {'object' | 'cluster' | string | ((trajectory: number) => string)} [color] by object, with the background
 *   smaller and fainter, if not given; by cluster; a CSS colour for all, or of each trajectory
 * @property {import('./palette.js').Shape | ((trajectory: number) => import('./palette.js').Shape)} [shape] of the
 *   points; with `color` by object or cluster their own, else discs, if not given
 * @property {Iterable<number> | ((object: number) => boolean)} [objects] whose trajectories are drawn; all, the
 *   background's too, if not given
 * @property {(trajectory: number) => boolean} [which] leaves out others
 */

/**
 * @typedef {{color: string, shape: import('./palette.js').Shape, muted: boolean, ids: number[]}} Group Trajectories
 *   that look alike.
 */

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
 * @param {import('./canvas.js').Context2D} context
 * @param {TrajectorySource} result
 * @param {number} t
 * @param {DrawTrajectoriesOptions} [options]
 */
export function drawTrajectories(context, result, t, options = {}) {
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
  /**
   * @param {TrajectorySource} result
   * @param {number} t
   */
  constructor(result, t) {
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
    this.result = result;
    this.t = t;
    this.x = result.trajectories.x;
    this.y = result.trajectories.y;
    /** @type {number[]} */
    this.ids = [];
    for (let i = 0; i < result.trajectories.count; i += 1) if (this.index(i, t) >= 0) this.ids.push(i);
  }

  /**
   * The place of a trajectory's point of frame `t` in `x` and `y`; -1 where it is not alive.
   * @param {number} i
   * @param {number} t
   */
  index(i, t) {
    const { startFrame, offset } = this.result.trajectories;
    const age = t - Number(startFrame[i]);
    return age >= 0 && age < Number(offset[i + 1]) - Number(offset[i]) ? Number(offset[i]) + age : -1;
  }

  /**
   * The object that a trajectory belongs to.
   * @param {number} i
   */
  object(i) {
    const { clusters, trajectories } = this.result;
    if (trajectories.label) return Number(trajectories.label[i]);
    const cluster = this.cluster(i);
    return clusters?.object ? Number(clusters.object[cluster]) : cluster;
  }

  /**
   * The cluster that a trajectory belongs to; its object where no clusters are known.
   * @param {number} i
   */
  cluster(i) {
    const { clusters, trajectories } = this.result;
    return Number((clusters ?? trajectories).label?.[i]);
  }

  /** How far points lie apart, about, in pixels. */
  distance() {
    return Math.sqrt((this.result.width * this.result.height) / Math.max(1, this.ids.length));
  }
}

/**
 * @param {FramePoints} points
 * @param {DrawTrajectoriesOptions} options
 * @returns {Group[]} those of the background first, then by object
 */
function grouped(points, { color = 'object', shape, objects, which }) {
  if (typeof color !== 'string' && typeof color !== 'function')
    throw illegal('param', 'color', color, "'object', 'cluster', a CSS colour, or a function of a trajectory");
  const shown = choice(objects);
  const label =
    color === 'cluster'
      ? (/** @type {number} */ i) => points.cluster(i)
      : (/** @type {number} */ i) => points.object(i);
  const own = color === 'object' || color === 'cluster';
  const colorOf = own
    ? (/** @type {number} */ i) => objectColor(inPalette(label(i)))
    : typeof color === 'function'
      ? color
      : () => color;
  const shapeOf =
    typeof shape === 'function'
      ? shape
      : (/** @type {number} */ i) => shape ?? (own ? objectShape(inPalette(label(i))) : 'disc');
  /** @type {Map<string, Group & {first: number}>} */
  const groups = new Map();
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

/**
 * @param {Iterable<number> | ((object: number) => boolean) | undefined} objects
 * @returns {(object: number) => boolean}
 */
export function choice(objects) {
  if (objects === undefined) return () => true;
  if (typeof objects === 'function') return objects;
  if (typeof objects !== 'object' || objects === null || !(Symbol.iterator in objects)) {
    throw illegal('param', 'objects', objects, 'a list of objects, or a function of one');
  }
  const chosen = new Set(objects);
  return (object) => chosen.has(object);
}

/** There may be more clusters than colours. @param {number} label */
function inPalette(label) {
  return label <= MAX_LABEL ? label : 1 + ((label - 1) % MAX_LABEL);
}

/**
 * @param {import('./canvas.js').Context2D} context
 * @param {FramePoints} points
 * @param {Group} group
 * @param {number} width
 * @param {number} tail
 */
function drawTails(context, points, { ids, color, muted }, width, tail) {
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

/**
 * @param {import('./canvas.js').Context2D} context
 * @param {FramePoints} points
 * @param {number[]} ids
 * @param {import('./palette.js').Shape} shape
 * @param {string} color
 * @param {number} radius
 */
function fillPoints(context, points, ids, shape, color, radius) {
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

/**
 * @param {import('./canvas.js').Context2D} context
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
function addDiamond(context, x, y, radius) {
  context.moveTo(x, y - radius);
  context.lineTo(x + radius, y);
  context.lineTo(x, y + radius);
  context.lineTo(x - radius, y);
  context.closePath();
}
