// Embedding discontinuities on a canvas: the Delaunay edges of a frame, those where motions part in red.

import { checkNumber, checkedOptions } from '../errors.js';
import { onPixelCentres } from './canvas.js';
import { strokePieces } from './outlines.js';
import { CUT_RED } from './palette.js';
import { FramePoints, choice } from './trajectories.js';

/**
 * Two trajectories each, and the discontinuity between them. @typedef {{i: ArrayLike<number>, j: ArrayLike<number>, d:
 * ArrayLike<number>}} EdgeEnds
 */

/**
 * What discontinuities are drawn of: a result. @typedef {import('./trajectories.js').TrajectorySource & {edges: (t:
 * number) => EdgeEnds}} EdgeSource
 */

/**
 * @typedef {object} DrawDiscontinuitiesOptions
 * @property {number} [threshold] discontinuity from which an edge is drawn as one, 0 to 1; 0.6 if not given
 * @property {number} [width] of a middling one, in pixels of the input; 2 if not given. Stronger ones are wider
 * @property {string} [color] CSS; red if not given
 * @property {string | null} [calm] CSS colour of the edges below the threshold; faint white if not given, null for none
 * @property {Iterable<number> | ((object: number) => boolean)} [objects] of which an edge must touch one; all if not
 *   given
 */

const LEGAL = ['threshold', 'width', 'color', 'calm', 'objects'];

/** Edges longer than this many typical ones are slivers along the hull and say nothing about neighbours. */
const MAX_STEPS = 6;

/** Edges are stroked in this many groups of like strength, because one stroke per edge is slow. */
const GRADES = 5;

const CALM = { color: 'rgb(255 255 255 / 0.14)', width: 0.3 };

/**
 * Draws the discontinuities between neighbouring trajectories of frame `t`. The context's unit is one pixel of the
 * input, its origin the frame's upper left corner (see `fitFrame`).
 * @param {import('./canvas.js').Context2D} context
 * @param {EdgeSource} result
 * @param {number} t
 * @param {DrawDiscontinuitiesOptions} [options]
 */
export function drawDiscontinuities(context, result, t, options = {}) {
  const { threshold = 0.6, width = 2, color = CUT_RED, calm = CALM.color, objects } = checkedOptions(options, LEGAL);
  checkNumber('threshold', threshold, 0, 1);
  checkNumber('width', width, 0, 1000);
  const sorted = sortEdges(new FramePoints(result, t), result.edges(t), threshold, choice(objects));
  onPixelCentres(context, () => {
    const alpha = context.globalAlpha;
    context.lineCap = 'round';
    if (calm !== null) {
      context.strokeStyle = calm;
      context.lineWidth = CALM.width * width;
      strokePieces(context, sorted.calm);
    }
    context.strokeStyle = color;
    sorted.cuts.forEach((pieces, grade) => {
      const strength = (grade + 0.5) / GRADES;
      context.globalAlpha = alpha * (0.45 + 0.55 * strength);
      context.lineWidth = (0.5 + strength) * width;
      strokePieces(context, pieces);
    });
  });
}

/**
 * @param {FramePoints} points
 * @param {EdgeEnds} edges
 * @param {number} threshold
 * @param {(object: number) => boolean} shown
 * @returns {{calm: number[], cuts: number[][]}} pieces of lines: up to the threshold, and above it by strength
 */
function sortEdges(points, { i, j, d }, threshold, shown) {
  const { x, y, t } = points;
  const ends = Array.from(i, (_, e) => [points.index(Number(i[e]), t), points.index(Number(j[e]), t)]);
  const lengths = ends.map(([a = -1, b = -1]) =>
    a < 0 || b < 0 ? Infinity : Math.hypot(Number(x[a]) - Number(x[b]), Number(y[a]) - Number(y[b])),
  );
  const finite = Float64Array.from(lengths.filter(Number.isFinite)).sort();
  const longest = MAX_STEPS * Number(finite[finite.length >> 1] ?? 0);
  /** @type {number[]} */
  const calm = [];
  /** @type {number[][]} */
  const cuts = Array.from({ length: GRADES }, () => []);
  ends.forEach(([a = -1, b = -1], e) => {
    if (Number(lengths[e]) > longest) return;
    if (!shown(points.object(Number(i[e]))) && !shown(points.object(Number(j[e])))) return;
    const strength = (Number(d[e]) - threshold) / (1 - threshold || 1);
    const pieces = Number(d[e]) > threshold ? cuts[Math.min(GRADES - 1, Math.floor(strength * GRADES))] : calm;
    pieces?.push(Number(x[a]), Number(y[a]), Number(x[b]), Number(y[b]));
  });
  return { calm, cuts };
}
