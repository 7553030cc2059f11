/**
 * The clip as videos: with its masks drawn over it, and its objects cut out.
 * @module
 */

import { SCREEN_GREEN, encodeVideo } from './library.js';
import { rateOf } from './export.js';

/** @typedef {import('./export.js').Subject} Subject */

/** The grounds of cut-out objects, on buttons. @type {Record<import('./look.js').GroundName, string>} */
const GROUNDS = {
  transparent: 'Transparent',
  green: 'Green',
  colour: 'Coloured',
  blurred: 'Blurred',
  desaturated: 'Grey around',
  dimmed: 'Spotlight',
  picture: 'Picture',
};

/** @type {import('./export.js').Export} */
export const overlayVideo = {
  title: 'Overlay video',
  about: 'The clip with the masks drawn over it.',
  choices: [video('overlay-webm', 'WebM', 'overlay', 'webm'), video('overlay-mp4', 'MP4', 'overlay', 'mp4')],
};

/** @type {import('./export.js').Export} */
export const cutoutVideo = {
  title: 'Cut-out video',
  about:
    'The objects alone, for an editor, on the ground of the view “Cut-out”. MP4 cannot be transparent: it is green then.',
  choices: [
    video('cutout-webm', (ground) => `${GROUNDS[ground]} WebM`, 'cutout', 'webm'),
    video('cutout-mp4', (ground) => `${GROUNDS[ground === 'transparent' ? 'green' : ground]} MP4`, 'cutout', 'mp4'),
  ],
};

/** @type {import('./export.js').Export} */
export const transparentVideo = {
  title: 'Transparent cut-out',
  about: 'WebM, for editors',
  choices: [video('transparent', 'WebM', 'cutout', 'webm', 'transparent')],
};

/** @type {import('./export.js').Export} */
export const greenVideo = {
  title: 'Green screen',
  about: 'MP4, for any editor',
  choices: [video('green', 'MP4', 'cutout', 'mp4', SCREEN_GREEN)],
};

/** @type {import('./export.js').Export} */
export const blurredVideo = {
  title: 'Blurred background',
  about: 'MP4, to be shared',
  choices: [video('blurred', 'MP4', 'cutout', 'mp4', 'blurred')],
};

/** @type {import('./export.js').Export} */
export const maskVideo = {
  title: 'Mask video',
  about: 'White where objects are, black elsewhere, grey in between: a track matte for an editor.',
  choices: [video('alpha-webm', 'WebM', 'alpha', 'webm'), video('alpha-mp4', 'MP4', 'alpha', 'mp4')],
};

/**
 * @param {string} id
 * @param {import('./export.js').Choice['label']} label
 * @param {'overlay' | 'cutout' | 'alpha'} style
 * @param {'webm' | 'mp4'} format
 * @param {import('./library.js').Ground} [own] a ground in place of that on screen
 * @returns {import('./export.js').Choice}
 */
function video(id, label, style, format, own) {
  return {
    id,
    label,
    file: () => `${style === 'alpha' ? 'mask' : style}.${format}`,
    make: (subject, work) => {
      const { masks, frames, objects, look, quality, ground, edges } = subject;
      const background = own ?? (format === 'mp4' && ground === 'transparent' ? SCREEN_GREEN : ground);
      const sound = subject.sound(format);
      return encodeVideo(masks, frames(work.signal), {
        style,
        format,
        objects,
        quality,
        edges,
        opacity: look.fill,
        maskOpacity: look.opacity,
        outlineWidth: look.outline,
        ...work,
        ...(style === 'cutout' ? { background } : {}),
        ...(sound ? { sound } : {}),
        ...rateOf(subject),
      });
    },
  };
}
