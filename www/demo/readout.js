/** The words in the corner of the picture about what lies under the pointer. @module */

import { byId } from './dom.js';
import { clusterName } from './palette.js';
import { count } from './words.js';

/**
 * @param {import('./points.js').Points | null} points
 * @param {number} trajectory -1 for none
 */
export function showReadout(points, trajectory) {
  const readout = byId('readout');
  readout.hidden = trajectory < 0 || !points;
  if (trajectory < 0 || !points) return;
  const { clusters, trajectories } = points.result;
  const first = trajectories.startFrame[trajectory];
  const last = first + trajectories.offset[trajectory + 1] - trajectories.offset[trajectory] - 1;
  const name = clusterName(clusters.label[trajectory]);
  readout.textContent = `${name} · trajectory ${count(trajectory)}, frames ${first + 1}–${last + 1}`;
}
