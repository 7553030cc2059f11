/** Masks as COCO JSON, trajectories as a track file. @module */

import { masksOf, rateOf } from './export.js';

/** @type {import('./export.js').Export} */
export const data = {
  title: 'Data',
  about: 'COCO run lengths for annotation tools; trajectories with their labels for the Moseg benchmark.',
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
      id: 'tracks',
      label: 'tracks.dat',
      file: () => 'tracks.dat',
      make: async ({ tracks }) => new Blob([tracks()], { type: 'text/plain' }),
    },
  ],
};
