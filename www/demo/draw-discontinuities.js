/** Embedding discontinuities on the Delaunay edges of the frame. @module */

import { key } from './dom.js';
import { opacity } from './layer.js';
import { CUT_RED } from './palette.js';

/** Edges longer than this many grid steps are slivers along the hull and say nothing about neighbours. */
const MAX_STEPS = 6;

/** Edges are stroked in this many groups of like strength, because one stroke per edge is slow. */
const GRADES = 5;

/** @returns {import('./layer.js').Layer} */
export function discontinuityLayer() {
  const threshold = {
    name: 'Above',
    value: 0.6,
    min: 0.05,
    max: 0.95,
    step: 0.05,
    text: (/** @type {number} */ v) => v.toFixed(2),
  };
  return {
    id: 'discontinuities',
    name: 'Discontinuities',
    key: '6',
    only: 'clip',
    about: 'Neighbouring points whose motions part: there an object ends.',
    z: 70,
    on: false,
    settings: { opacity: opacity(), threshold },
    legend: () => [key('line', CUT_RED, 'motions part'), key('thin', 'currentcolor', 'neighbours that move alike')],
    draw(ctx, view) {
      if (!view.points) return;
      const { calm, cuts } = sortEdges(view, threshold.value);
      ctx.lineCap = 'round';
      ctx.strokeStyle = 'rgb(255 255 255 / 0.14)';
      ctx.lineWidth = 0.6 * view.unit;
      strokeEdges(ctx, view, calm);
      ctx.strokeStyle = CUT_RED;
      cuts.forEach((edges, grade) => {
        const strength = (grade + 0.5) / GRADES;
        ctx.globalAlpha = 0.45 + 0.55 * strength;
        ctx.lineWidth = (1 + 2 * strength) * view.unit;
        strokeEdges(ctx, view, edges);
      });
      ctx.globalAlpha = 1;
    },
  };
}

/**
 * @param {import('./layer.js').View} view
 * @param {number} threshold
 * @returns {{calm: number[], cuts: number[][]}} ends of the edges, as pairs of indices into the points: those up to the
 *   threshold, and those above it by strength
 */
function sortEdges(view, threshold) {
  const points = /** @type {import('./points.js').Points} */ (view.points);
  const { i, j, d } = points.result.edges(view.frame);
  const longest = MAX_STEPS * points.spacing(view.frame);
  /** @type {number[]} */
  const calm = [];
  /** @type {number[][]} */
  const cuts = Array.from({ length: GRADES }, () => []);
  for (let e = 0; e < d.length; e++) {
    if (!view.visible(points.object[i[e]]) && !view.visible(points.object[j[e]])) continue;
    const a = points.index(i[e], view.frame);
    const b = points.index(j[e], view.frame);
    if (a < 0 || b < 0 || points.distance(a, b) > longest) continue;
    const grade = Math.min(GRADES - 1, Math.floor(((d[e] - threshold) / (1 - threshold)) * GRADES));
    (d[e] > threshold ? cuts[grade] : calm).push(a, b);
  }
  return { calm, cuts };
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./layer.js').View} view
 * @param {number[]} ends
 */
function strokeEdges(ctx, view, ends) {
  const { x, y } = /** @type {import('./points.js').Points} */ (view.points).result.trajectories;
  ctx.beginPath();
  for (let e = 0; e < ends.length; e += 2) {
    ctx.moveTo(x[ends[e]], y[ends[e]]);
    ctx.lineTo(x[ends[e + 1]], y[ends[e + 1]]);
  }
  ctx.stroke();
}
