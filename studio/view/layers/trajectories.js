/**
 * What lies on trajectories: their points, the embedding as colours, discontinuities between neighbours.
 * @module
 */

import { drawCells, drawTrajectories, drawDiscontinuities } from '../library.js';
import { key, h } from '../dom.js';
import { fromCorner, opacity } from './layer.js';
import { objectColor, CUT_RED } from '../result/palette.js';
import { NOTHING } from '../words.js';
import { LastPicture, picture } from './fetched.js';
import { quantile } from '../result/points.js';

/** @typedef {import('./layer.js').View} View */

/** The tint reaches this far from a point, in distances between points: neighbours' cells just close up. */
const TINT_STEPS = 0.75;

/** @returns {import('./layer.js').Layer} */
export function trajectoryLayer() {
  const trail = trailLength(8);
  const tint = { ...opacity(0.35), name: 'Tint' };
  const cells = new LastPicture();
  return {
    id: 'trajectories',
    name: 'Trajectories',
    key: '2',
    only: 'clip',
    about: 'Points followed from frame to frame, coloured by object. Pixels are tinted like the nearest point.',
    ofWindows: true,
    z: 60,
    on: false,
    settings: { opacity: opacity(), trail, tint },
    legend: () => [key('dot', objectColor(0), 'background'), key('dot', objectColor(1), 'objects, colours as listed')],
    missing: ({ windows, points }) => (windows && !points?.result.trajectories.count ? NOTHING.joined : ''),
    reset: () => cells.reset(),
    draw(ctx, view) {
      const { points, frame, visible } = view;
      if (!points) return;
      fromCorner(ctx, () => {
        ctx.globalAlpha = tint.value;
        ctx.drawImage(
          cells.get(cellKey(view), () => tinted(view)),
          0,
          0,
        );
        ctx.globalAlpha = 1;
        drawTrajectories(ctx, points.result, frame, { tail: trail.value, objects: visible, ...markerSize(view) });
      });
    },
  };
}

/**
 * @param {import('./layer.js').View} view
 * @returns {string} what the picture of cells depends on
 */
function cellKey({ points, frame, visible }) {
  return `${frame} ${Array.from({ length: points?.count ?? 0 }, (_, object) => visible(object))}`;
}

/** @param {import('./layer.js').View} view */
function tinted(view) {
  const { frame, visible } = view;
  const points = /** @type {import('../result/points.js').Points} */ (view.points);
  const color = (/** @type {number} */ i) =>
    points.object[i] > 0 && visible(points.object[i]) ? objectColor(points.object[i]) : null;
  const reach = Math.max(2, TINT_STEPS * points.spacing(frame));
  return picture(view, (ctx) => drawCells(ctx, points.result, frame, { color, reach }));
}

/** Radius of a point against the distance between points, and its bounds in CSS pixels. */
const RADIUS = { share: 0.17, least: 1.1, most: 4 };

/** Width of a tail in CSS pixels. */
const TAIL_WIDTH = 1.5;

/**
 * @param {View} view with a result
 * @returns {{radius: number, width: number}} of points and of their tails, in clip pixels
 */
export function markerSize(view) {
  const points = /** @type {import('../result/points.js').Points} */ (view.points);
  const wanted = (RADIUS.share * points.spacing(view.frame)) / view.unit;
  return { radius: Math.min(RADIUS.most, Math.max(RADIUS.least, wanted)) * view.unit, width: TAIL_WIDTH * view.unit };
}

/**
 * How many frames of its way a point shows behind it.
 *
 * @param {number} value
 * @returns {import('./layer.js').Setting}
 */
export function trailLength(value) {
  return { name: 'Trail', value, min: 0, max: 24, step: 1, text: (v) => (v === 0 ? 'none' : `${v} frames`) };
}

/** Eigenvectors shown: the first is constant on a connected graph and says nothing. */
const CHANNELS = [1, 2, 3];

/** @returns {import('./layer.js').Layer} */
export function embeddingLayer() {
  /** @type {string[] | null} */
  let colors = null;
  const cells = new LastPicture();
  return {
    id: 'embedding',
    name: 'Embedding colours',
    key: '7',
    only: 'clip',
    about: 'Points of like colour have moved alike over their whole life.',
    z: 20,
    on: false,
    settings: { opacity: opacity(0.85) },
    legend: () => [
      h(
        'span',
        { class: 'key' },
        ...['red', 'green', 'blue'].map((c) => h('span', { class: `chip chip-${c}`, 'aria-hidden': 'true' })),
        'eigenvectors 2, 3 and 4',
      ),
    ],
    reset() {
      colors = null;
      cells.reset();
    },
    draw(ctx, view) {
      const { points, frame, visible } = view;
      if (!points) return;
      const known = (colors ??= embeddingColors(points.result));
      const color = (/** @type {number} */ i) => (visible(points.object[i]) ? known[i] : null);
      const reach = Math.max(2, points.spacing(frame));
      const canvas = cells.get(cellKey(view), () =>
        picture(view, (own) => drawCells(own, points.result, frame, { color, reach })),
      );
      fromCorner(ctx, () => {
        ctx.imageSmoothingEnabled = false;
        ctx.drawImage(canvas, 0, 0);
      });
    },
  };
}

/**
 * @param {import('../result/points.js').Result} result
 * @returns {string[]} a colour per trajectory; each channel spans 2 % to 98 % of its values
 */
function embeddingColors(result) {
  const { dimensions, vectors } = result.embedding;
  const n = result.trajectories.count;
  const channels = CHANNELS.map((column) => {
    if (column >= dimensions) return new Float32Array(n).fill(0.5);
    const values = Float32Array.from({ length: n }, (_, i) => vectors[i * dimensions + column]);
    const low = quantile(values, 0.02);
    const span = quantile(values, 0.98) - low || 1;
    return values.map((value) => Math.min(1, Math.max(0, (value - low) / span)));
  });
  const hex = (/** @type {number} */ value) =>
    Math.floor(44 + 200 * value)
      .toString(16)
      .padStart(2, '0');
  return Array.from({ length: n }, (_, i) => `#${channels.map((values) => hex(values[i])).join('')}`);
}

/** Width of a middling discontinuity in CSS pixels. */
const WIDTH = 2;

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
    draw(ctx, { points, frame, unit, visible }) {
      if (!points) return;
      const options = { threshold: threshold.value, width: WIDTH * unit, objects: visible };
      fromCorner(ctx, () => drawDiscontinuities(ctx, points.result, frame, options));
    },
  };
}
