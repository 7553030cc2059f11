/** Trajectory points by object, each with the last part of its way. @module */

import { CellPainter, packColors } from './cells.js';
import { key } from './dom.js';
import { opacity } from './layer.js';
import { drawMarkers, drawTrails, markerRadius } from './markers.js';
import { objectColor, objectShape, rgbOf } from './palette.js';

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
    key: '2',
    only: 'clip',
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
      groups.forEach((ids, object) => drawTrails(ctx, view, ids, trailStyle(object), trail.value));
      const radius = markerRadius(view);
      groups.forEach((ids, object) => {
        const own = object === 0 ? BACKGROUND_SIZE * radius : radius;
        drawMarkers(ctx, view, ids, { color: objectColor(object), shape: objectShape(object), radius: own });
      });
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

/** @param {number} object */
function trailStyle(object) {
  return { color: objectColor(object), strength: object === 0 ? 0.45 : 0.9, width: object === 0 ? 0.8 : 1.5 };
}
