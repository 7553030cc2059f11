/** Trajectory points by object, each with the last part of its way. @module */

import { CellPainter, packColors } from './cells.js';
import { key } from './dom.js';
import { opacity } from './layer.js';
import { objectColor, objectShape, rgbOf } from './palette.js';

/** Radius of a point against the distance between points, and its bounds in CSS pixels. */
const RADIUS = { share: 0.17, least: 1.1, most: 4 };

/** The tint reaches this far from a point, in distances between points: neighbours' cells just close up. */
const TINT_STEPS = 0.75;

/** The background's points are smaller by this, so that objects stand out. */
const BACKGROUND_SIZE = 0.5;

/** @returns {import('./layer.js').Layer} */
export function trajectoryLayer() {
  const trail = {
    name: 'Trail',
    value: 8,
    min: 0,
    max: 24,
    step: 1,
    text: (/** @type {number} */ v) => (v === 0 ? 'none' : `${v} frames`),
  };
  const tint = { ...opacity(0.35), name: 'Tint' };
  /** @type {Uint32Array | null} */
  let colors = null;
  const cells = new CellPainter((view) => {
    colors ??= tintColors(/** @type {import('./points.js').Points} */ (view.points));
    return colors;
  }, TINT_STEPS);
  return {
    id: 'trajectories',
    name: 'Trajectories',
    about: 'Points followed from frame to frame, coloured by object. Pixels are tinted like the nearest point.',
    z: 60,
    on: false,
    settings: { opacity: opacity(), trail, tint },
    legend: () => [key('dot', objectColor(0), 'background'), key('dot', objectColor(1), 'objects, colours as listed')],
    reset() {
      colors = null;
      cells.reset();
    },
    draw(ctx, view) {
      if (!view.points) return;
      ctx.globalAlpha = tint.value;
      cells.draw(ctx, view);
      ctx.globalAlpha = 1;
      const groups = groupByObject(view);
      ctx.lineCap = 'round';
      groups.forEach((ids, object) => drawTrails(ctx, view, ids, object, trail.value));
      groups.forEach((ids, object) => drawPoints(ctx, view, ids, object));
    },
  };
}

/**
 * @param {import('./points.js').Points} points
 * @returns {Uint32Array} per trajectory the colour of its object; clear for the background
 */
function tintColors({ count, object }) {
  const palette = Array.from({ length: count }, (_, k) => rgbOf(objectColor(k)));
  return packColors(object.length, (i, out, at) => {
    const { r, g, b } = palette[object[i]];
    out.set([r, g, b, object[i] === 0 ? 0 : 255], at);
  });
}

/**
 * @param {import('./layer.js').View} view
 * @returns {number[][]} for each object the visible trajectories alive in the frame
 */
function groupByObject(view) {
  const points = /** @type {import('./points.js').Points} */ (view.points);
  /** @type {number[][]} */
  const groups = Array.from({ length: points.count }, () => []);
  for (const id of points.at(view.frame).id) {
    if (view.visible(points.object[id])) groups[points.object[id]].push(id);
  }
  return groups;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./layer.js').View} view
 * @param {number[]} ids
 * @param {number} object
 * @param {number} length frames back
 */
function drawTrails(ctx, view, ids, object, length) {
  const points = /** @type {import('./points.js').Points} */ (view.points);
  const { x, y } = points.result.trajectories;
  const strength = object === 0 ? 0.45 : 0.9;
  ctx.strokeStyle = objectColor(object);
  ctx.lineWidth = (object === 0 ? 0.8 : 1.5) * view.unit;
  // One path per age: each step back in time is a little fainter.
  for (let back = length; back >= 1; back--) {
    ctx.globalAlpha = strength * (1 - back / (length + 1));
    ctx.beginPath();
    for (const id of ids) {
      const from = points.index(id, view.frame - back);
      if (from < 0) continue;
      ctx.moveTo(x[from], y[from]);
      ctx.lineTo(x[from + 1], y[from + 1]);
    }
    ctx.stroke();
  }
  ctx.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./layer.js').View} view
 * @param {number[]} ids
 * @param {number} object
 */
function drawPoints(ctx, view, ids, object) {
  const points = /** @type {import('./points.js').Points} */ (view.points);
  const wanted = (RADIUS.share * points.spacing(view.frame)) / view.unit;
  const size = Math.min(RADIUS.most, Math.max(RADIUS.least, wanted)) * view.unit;
  const radius = object === 0 ? BACKGROUND_SIZE * size : size;
  // A dark rim keeps the colours legible on bright footage.
  ctx.fillStyle = 'rgb(0 0 0 / 0.5)';
  fillMarkers(ctx, view, ids, object, radius + 0.6 * view.unit);
  ctx.fillStyle = objectColor(object);
  fillMarkers(ctx, view, ids, object, radius);
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./layer.js').View} view
 * @param {number[]} ids
 * @param {number} object
 * @param {number} radius clip pixels
 */
function fillMarkers(ctx, view, ids, object, radius) {
  const points = /** @type {import('./points.js').Points} */ (view.points);
  const { x, y } = points.result.trajectories;
  const shape = objectShape(object);
  ctx.beginPath();
  for (const id of ids) {
    const at = points.index(id, view.frame);
    if (shape === 'disc') {
      ctx.moveTo(x[at] + radius, y[at]);
      ctx.arc(x[at], y[at], radius, 0, 2 * Math.PI);
    } else if (shape === 'square') {
      ctx.rect(x[at] - radius, y[at] - radius, 2 * radius, 2 * radius);
    } else {
      addDiamond(ctx, x[at], y[at], 1.3 * radius);
    }
  }
  ctx.fill();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 */
function addDiamond(ctx, x, y, radius) {
  ctx.moveTo(x, y - radius);
  ctx.lineTo(x + radius, y);
  ctx.lineTo(x, y + radius);
  ctx.lineTo(x - radius, y);
  ctx.closePath();
}
