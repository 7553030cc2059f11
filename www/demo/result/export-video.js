/** The clip with its masks drawn over it, and its objects cut out, as videos. @module */

import { rateOf } from './export.js';

/** The green of screens. */
const GREEN = '#00b140';

/** @type {import('./export.js').Export} */
export const overlayVideo = {
  title: 'Overlay video',
  about: 'The clip with the masks drawn over it.',
  choices: [video('overlay-webm', 'WebM', 'overlay', 'webm'), video('overlay-mp4', 'MP4', 'overlay', 'mp4')],
};

/** @type {import('./export.js').Export} */
export const cutoutVideo = {
  title: 'Cut-out video',
  about: 'The objects alone, for an editor: on a transparent or on a green ground.',
  choices: [
    video('cutout-webm', 'Transparent WebM', 'cutout', 'webm', 'transparent'),
    video('cutout-mp4', 'Green MP4', 'cutout', 'mp4', GREEN),
  ],
};

/**
 * @param {string} id
 * @param {string} label
 * @param {'overlay' | 'cutout'} style
 * @param {'webm' | 'mp4'} format
 * @param {string} [background]
 * @returns {import('./export.js').Choice}
 */
function video(id, label, style, format, background) {
  return {
    id,
    label,
    says: `${style === 'overlay' ? 'Overlay' : 'Cut-out'} video as ${label}`,
    file: () => `${style}.${format}`,
    make: (subject, work) => {
      const { library, masks, frames, objects, look, quality } = subject;
      const ground = background ? { background } : {};
      const sound = subject.sound(format);
      return library.encodeVideo(masks, frames(work.signal), {
        style,
        format,
        objects,
        quality,
        opacity: look.fill,
        maskOpacity: look.opacity,
        outlineWidth: look.outline,
        ...work,
        ...ground,
        ...(sound ? { sound } : {}),
        ...rateOf(subject),
      });
    },
  };
}
