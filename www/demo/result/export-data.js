/** Masks as COCO JSON, objects as a table, trajectories as a track file. @module */

import { masksOf, rateOf } from './export.js';

/** @type {import('./export.js').Export} */
export const data = {
  title: 'Data',
  about:
    'COCO run lengths for annotation tools; a table of objects; trajectories with their labels for the Moseg benchmark.',
  choices: [
    {
      id: 'coco',
      label: 'COCO JSON',
      file: () => 'coco.json',
      make: async (subject, work) => {
        const { library, objects, name } = subject;
        const coco = library.cocoRle(await masksOf(subject, work), { objects, video: name, ...rateOf(subject) });
        return new Blob([JSON.stringify(coco)], { type: 'application/json' });
      },
    },
    {
      id: 'table',
      label: 'objects.csv',
      says: 'objects.csv: place, size and motion of the objects in each frame',
      file: () => 'objects.csv',
      make: async (subject, work) => {
        const { library, objects, points } = subject;
        const masks = await masksOf(subject, work);
        const trajectories = enlarged(points, masks.width / subject.masks.width, masks.height / subject.masks.height);
        const rows = await library.objectTable(masks, { trajectories, objects, ...rateOf(subject) });
        return new Blob([await library.objectTableCsv(rows)], { type: 'text/csv' });
      },
    },
    {
      id: 'tracks',
      label: 'tracks.dat',
      file: () => 'tracks.dat',
      make: async ({ tracks }) => new Blob([tracks()], { type: 'text/plain' }),
    },
  ],
};

/**
 * Points of trajectories in pixels of masks that are so much larger.
 *
 * @param {import('../../dist/export.js').TrajectoryPoints} points
 * @param {number} across
 * @param {number} down
 */
function enlarged({ startFrame, offset, x, y }, across, down) {
  const by = (/** @type {ArrayLike<number>} */ values, /** @type {number} */ scale) =>
    Float32Array.from(values, (value) => (value + 0.5) * scale - 0.5);
  return { startFrame, offset, x: by(x, across), y: by(y, down) };
}
