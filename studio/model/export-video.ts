// Video exports: overlay, cut-out and mask.

import { encodeVideo } from './library.js';
import { type Choice, type Export, frameRateOption } from './export.js';
import { type BackdropName, toCutoutBackdrop } from './view-settings.js';
import type { State } from './store.js';

const BACKDROP_LABELS: Record<BackdropName, string> = {
  transparent: 'Transparent',
  green: 'Green',
  colour: 'Colour',
  blurred: 'Blurred',
  desaturated: 'Grey',
  dimmed: 'Spotlight',
  picture: 'Picture',
};

/** Suffixes of the names of cut-out files. */
const BACKDROP_SUFFIXES: Record<BackdropName, string> = {
  transparent: 'cutout',
  green: 'green',
  colour: 'colour',
  blurred: 'blur',
  desaturated: 'grey',
  dimmed: 'spotlight',
  picture: 'picture',
};

export const overlayVideo: Export = {
  title: 'Overlay video',
  about: 'The clip with the masks on top.',
  choices: [
    videoChoice('overlay-webm', 'WebM', 'overlay', 'webm'),
    videoChoice('overlay-mp4', 'MP4', 'overlay', 'mp4'),
  ],
};

export const cutoutVideo: Export = {
  title: 'Cut-out video',
  about: 'The objects on the backdrop of the “Cut-out” view. MP4 has no transparency: green is used instead.',
  choices: [
    videoChoice('cutout-webm', (backdrop) => `${BACKDROP_LABELS[backdrop]} WebM`, 'cutout', 'webm'),
    videoChoice(
      'cutout-mp4',
      (backdrop) => `${BACKDROP_LABELS[backdrop === 'transparent' ? 'green' : backdrop]} MP4`,
      'cutout',
      'mp4',
    ),
  ],
};

export const transparentVideo: Export = {
  title: 'Transparent cut-out',
  about: 'WebM, for editing',
  choices: [videoChoice('transparent', 'WebM', 'cutout', 'webm', 'transparent')],
};

export const greenVideo: Export = {
  title: 'Green screen',
  about: 'MP4, for any editor',
  choices: [videoChoice('green', 'MP4', 'cutout', 'mp4', 'green')],
};

export const blurredVideo: Export = {
  title: 'Blurred background',
  about: 'MP4, for sharing',
  choices: [videoChoice('blurred', 'MP4', 'cutout', 'mp4', 'blurred')],
};

export const maskVideo: Export = {
  title: 'Mask video',
  about: 'White objects on black: a track matte for editing.',
  choices: [videoChoice('alpha-webm', 'WebM', 'alpha', 'webm'), videoChoice('alpha-mp4', 'MP4', 'alpha', 'mp4')],
};

/** @param backdrop replaces the backdrop on screen */
function videoChoice(
  id: string,
  label: Choice['label'],
  style: 'overlay' | 'cutout' | 'alpha',
  format: 'webm' | 'mp4',
  backdrop?: BackdropName,
): Choice {
  const backdropOf = (state: State) => {
    const name = backdrop ?? state.backdrop.name;
    return format === 'mp4' && name === 'transparent' ? 'green' : name;
  };
  const suffixes = {
    overlay: () => 'overlay',
    cutout: (state: State) => BACKDROP_SUFFIXES[backdropOf(state)],
    alpha: () => 'mask',
  };
  return {
    id,
    label,
    file: ({ state }) => `${suffixes[style](state)}.${format}`,
    make: (subject, task) => {
      const { masks, frames, objects, maskStyle, quality, edges, state } = subject;
      const background = toCutoutBackdrop({ ...state.backdrop, name: backdropOf(state) });
      const sound = subject.sound(format);
      return encodeVideo(masks, frames(task.signal), {
        style,
        format,
        objects,
        quality,
        edges,
        opacity: maskStyle.fill,
        maskOpacity: maskStyle.opacity,
        outlineWidth: maskStyle.outline,
        ...task,
        ...(style === 'cutout' ? { background } : {}),
        ...(sound ? { sound } : {}),
        ...frameRateOption(subject),
      });
    },
  };
}
