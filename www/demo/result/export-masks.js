/** Masks as PNG files: all in a ZIP, or the one of a frame. @module */

import { labelsOf, masksOf, rateOf } from './export.js';

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
      make: async (subject) => {
        const { library, frame, objects } = subject;
        const image = await subject.image(frame);
        const labels = (await labelsOf(subject, frame, image)).map((label) => (objects(label) ? label : 0));
        const { width, height } = image;
        const mask = { width, height, numFrames: 1, labels: () => labels };
        return new Blob([await library.maskPng(mask, 0)], { type: 'image/png' });
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
    const { library, objects } = subject;
    const bytes = await library.masksZip(await masksOf(subject, work), {
      perObject,
      objects,
      ...work,
      ...rateOf(subject),
    });
    return new Blob([bytes], { type: 'application/zip' });
  };
}
