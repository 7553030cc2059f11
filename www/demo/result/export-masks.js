/** Masks as PNG files: all in a ZIP, or that of one frame. @module */

import { rateOf } from './export.js';

/** @type {import('./export.js').Export} */
export const masks = {
  title: 'Masks of all frames',
  about:
    'A ZIP of PNG files in the colours of the page, or a folder of black and white ones for each object. Times are in masks.json.',
  choices: [
    { id: 'zip', label: 'ZIP, in colours', file: () => 'masks.zip', make: zip(false) },
    { id: 'zip-objects', label: 'ZIP, by object', file: () => 'objects.zip', make: zip(true) },
  ],
};

/** @type {import('./export.js').Export} */
export const frameMask = {
  title: 'Mask of this frame',
  about: 'One PNG in the colours of the page.',
  choices: [
    {
      id: 'png',
      label: 'PNG',
      says: 'Mask of this frame as PNG',
      file: ({ frame }) => `mask-${String(frame + 1).padStart(4, '0')}.png`,
      make: async ({ library, masks: all, frame, objects }) => {
        const labels = all.labels(frame).map((label) => (objects(label) ? label : 0));
        return new Blob([await library.maskPng({ ...all, labels: () => labels }, frame)], { type: 'image/png' });
      },
    },
  ],
};

/**
 * @param {boolean} perObject
 * @returns {import('./export.js').Choice['make']}
 */
function zip(perObject) {
  return async (subject, work) => {
    const { library, masks: all, objects } = subject;
    const bytes = await library.masksZip(all, { perObject, objects, ...work, ...rateOf(subject) });
    return new Blob([bytes], { type: 'application/zip' });
  };
}
