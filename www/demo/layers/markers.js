/** How points of trajectories look at the viewer's zoom. @module */

import { say } from '../language.js';

/** @typedef {import('./layer.js').View} View */

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
  return { name: 'Trail', value, min: 0, max: 24, step: 1, text: (v) => (v === 0 ? say('none') : say`${v} frames`) };
}
