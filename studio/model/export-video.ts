// The clip as videos: with its masks drawn over it, and its objects cut out.

import { type Backdrop as Ground, SCREEN_GREEN, encodeVideo } from './library.js';
import { type Choice, type Export, rateOf } from './export.js';
import type { GroundName } from './look.js';

/** The grounds of cut-out objects, on buttons. */
const GROUNDS: Record<GroundName, string> = {
  transparent: 'Transparent',
  green: 'Green',
  colour: 'Coloured',
  blurred: 'Blurred',
  desaturated: 'Grey around',
  dimmed: 'Spotlight',
  picture: 'Picture',
};

export const overlayVideo: Export = {
  title: 'Overlay video',
  about: 'The clip with the masks drawn over it.',
  choices: [video('overlay-webm', 'WebM', 'overlay', 'webm'), video('overlay-mp4', 'MP4', 'overlay', 'mp4')],
};

export const cutoutVideo: Export = {
  title: 'Cut-out video',
  about:
    'The objects alone, for an editor, on the ground of the view “Cut-out”. MP4 cannot be transparent: it is green then.',
  choices: [
    video('cutout-webm', (ground) => `${GROUNDS[ground]} WebM`, 'cutout', 'webm'),
    video('cutout-mp4', (ground) => `${GROUNDS[ground === 'transparent' ? 'green' : ground]} MP4`, 'cutout', 'mp4'),
  ],
};

export const transparentVideo: Export = {
  title: 'Transparent cut-out',
  about: 'WebM, for editors',
  choices: [video('transparent', 'WebM', 'cutout', 'webm', 'transparent')],
};

export const greenVideo: Export = {
  title: 'Green screen',
  about: 'MP4, for any editor',
  choices: [video('green', 'MP4', 'cutout', 'mp4', SCREEN_GREEN)],
};

export const blurredVideo: Export = {
  title: 'Blurred background',
  about: 'MP4, to be shared',
  choices: [video('blurred', 'MP4', 'cutout', 'mp4', 'blurred')],
};

export const maskVideo: Export = {
  title: 'Mask video',
  about: 'White where objects are, black elsewhere, grey in between: a track matte for an editor.',
  choices: [video('alpha-webm', 'WebM', 'alpha', 'webm'), video('alpha-mp4', 'MP4', 'alpha', 'mp4')],
};

/** @param own a ground in place of that on screen */
function video(
  id: string,
  label: Choice['label'],
  style: 'overlay' | 'cutout' | 'alpha',
  format: 'webm' | 'mp4',
  own?: Ground,
): Choice {
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
