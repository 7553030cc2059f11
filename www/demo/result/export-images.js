/** Objects cut out, as pictures with alpha: PNG files in a ZIP, or one animated PNG; written while they are made. @module */

import { rateOf } from './export.js';

/** @type {import('./export.js').Export} */
export const images = {
  title: 'Cut-out pictures',
  about:
    'The objects alone on nothing, for editors that want pictures. An animated PNG plays in browsers and chats as a GIF does.',
  choices: [
    stream('cutout-zip', 'ZIP of PNG files', 'cutout.zip', 'cutout', 'zip'),
    stream('cutout-apng', 'Animated PNG', 'cutout.png', 'cutout', 'apng'),
    stream('alpha-zip', 'Alpha alone, ZIP', 'alpha.zip', 'alpha', 'zip'),
  ],
};

/**
 * @param {string} id
 * @param {string} label
 * @param {string} file
 * @param {'cutout' | 'alpha'} style
 * @param {'zip' | 'apng'} format
 * @returns {import('./export.js').Choice}
 */
function stream(id, label, file, style, format) {
  return {
    id,
    label,
    file: () => file,
    type: format === 'zip' ? 'application/zip' : 'image/png',
    make: (subject, work) => {
      const { library, masks, frames, objects, edges, trail } = subject;
      const options = { style, format, objects, edges, trail, ...work, ...rateOf(subject) };
      return library.encodeImages(masks, frames(work.signal), options);
    },
  };
}
