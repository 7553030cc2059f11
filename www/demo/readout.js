/** The words in the corner of the picture about what lies under the pointer. @module */

import { byId } from './dom.js';
import { objectName } from './palette.js';
import { count } from './words.js';

/**
 * @param {import('./points.js').Points | null} points
 * @param {import('./layer.js').Spot} spot
 * @param {string[]} [more] what the layers say about it
 */
export function showReadout(points, { object, trajectory }, more = []) {
  const words = [];
  if (points && object >= 0) {
    words.push(objectName(object));
    if (trajectory >= 0) words.push(`trajectory ${count(trajectory)}, ${lifeOf(points, trajectory)}`);
  }
  words.push(...more.filter((text) => text !== ''));
  const readout = byId('readout');
  readout.hidden = words.length === 0;
  if (words.length > 0) readout.textContent = words.join(' · ');
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
