/** The words in the corner of the picture about what lies under the pointer. @module */

import { byId } from './dom.js';
import { objectName } from './palette.js';
import { count } from './words.js';

/**
 * @param {import('./points.js').Points | null} points
 * @param {import('./viewer.js').Spot} spot
 */
export function showReadout(points, { object, trajectory }) {
  const readout = byId('readout');
  readout.hidden = object < 0 || !points;
  if (object < 0 || !points) return;
  const words = [objectName(object)];
  if (trajectory >= 0) words.push(`trajectory ${count(trajectory)}, ${lifeOf(points, trajectory)}`);
  readout.textContent = words.join(' · ');
}

/**
 * @param {import('./points.js').Points} points
 * @param {number} trajectory
 */
function lifeOf({ result }, trajectory) {
  const { startFrame, offset } = result.trajectories;
  const first = startFrame[trajectory];
  return `frames ${first + 1}–${first + offset[trajectory + 1] - offset[trajectory]}`;
}
