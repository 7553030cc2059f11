/**
 * The clip as videos and pictures: with its masks drawn over it, its objects cut out, the scene without its objects.
 * @module
 */

import { encodeVideo } from '../library.js';
import { GREEN } from '../panels/views.js';
import { rateOf, labelsOf } from './export.js';

/** @typedef {import('./export.js').Subject} Subject */

/** The grounds of cut-out objects, on buttons. @type {Record<import('../panels/views.js').GroundName, string>} */
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
  choices: [video('green', 'MP4', 'cutout', 'mp4', GREEN)],
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
 * @param {import('../library.js').Ground} [own] a ground in place of that on screen
 * @returns {import('./export.js').Choice}
 */
function video(id, label, style, format, own) {
  return {
    id,
    label,
    file: () => `${style === 'alpha' ? 'mask' : style}.${format}`,
    make: (subject, work) => {
      const { masks, frames, objects, look, quality, ground, edges } = subject;
      const background = own ?? (format === 'mp4' && ground === 'transparent' ? GREEN : ground);
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

/** The plate reaches this far under the frame's own pixels around an object, in pixels of the plate. */
const MARGIN = 2;

/** @type {import('./export.js').Export} */
export const background = {
  title: 'Background',
  about:
    'The scene without any of the objects, for an editor: other frames show what is behind them. What none of them shows is transparent.',
  choices: [
    {
      id: 'background-png',
      label: 'PNG',
      says: 'Background of this frame as PNG',
      file: ({ frame }) => `background-${numbered(frame)}.png`,
      there: ({ plate }) => plate !== null,
      make: async (subject) => withoutObjects(subject, subject.frame, await subject.image(subject.frame)),
    },
    {
      id: 'background-zip',
      label: 'ZIP, all frames',
      file: () => 'background.zip',
      there: ({ plate }) => plate !== null,
      make: zip,
    },
  ],
};

/** @type {import('./export.js').Choice['make']} */
async function zip(subject, { signal, onProgress }) {
  const { zipSync } = await import('fflate');
  const { numFrames } = subject.masks;
  /** @type {Record<string, Uint8Array>} */
  const files = {};
  let t = 0;
  for await (const frame of subject.frames(signal)) {
    signal.throwIfAborted();
    files[`${numbered(t)}.png`] = new Uint8Array(await (await withoutObjects(subject, t, frame)).arrayBuffer());
    t += 1;
    onProgress({ done: t, total: numFrames });
  }
  // PNG files are compressed already. The date is the first that ZIP knows.
  return new Blob([zipSync(files, { level: 0, mtime: new Date(1980, 0, 1) })], { type: 'application/zip' });
}

/** @param {number} frame */
function numbered(frame) {
  return String(frame + 1).padStart(4, '0');
}

/**
 * A frame at its own size, with the plate, which may be smaller, where objects are and close around them.
 *
 * @param {Subject} subject
 * @param {number} t
 * @param {ImageData} own the frame
 */
async function withoutObjects(subject, t, own) {
  const { plate } = subject;
  if (!plate) throw new Error('there is no background');
  const found = await plate(t);
  const { width, height } = own;
  const canvas = new OffscreenCanvas(width, height);
  const ctx = contextOf(canvas);
  ctx.putImageData(own, 0, 0);
  ctx.globalCompositeOperation = 'destination-out';
  const [reachX, reachY] = [(MARGIN * width) / found.width, (MARGIN * height) / found.height];
  const covered = shapeOf(await labelsOf(subject, t, own), width, height);
  for (const x of [-reachX, 0, reachX]) for (const y of [-reachY, 0, reachY]) ctx.drawImage(covered, x, y);
  ctx.globalCompositeOperation = 'destination-over';
  ctx.imageSmoothingQuality = 'high';
  const small = new OffscreenCanvas(found.width, found.height);
  contextOf(small).putImageData(new ImageData(found.data, found.width, found.height), 0, 0);
  ctx.drawImage(small, 0, 0, width, height);
  return canvas.convertToBlob({ type: 'image/png' });
}

/**
 * Where any object is.
 *
 * @param {Uint8Array} labels
 * @param {number} width
 * @param {number} height
 */
function shapeOf(labels, width, height) {
  const shape = new ImageData(width, height);
  labels.forEach((label, p) => (shape.data[4 * p + 3] = label > 0 ? 255 : 0));
  const canvas = new OffscreenCanvas(width, height);
  contextOf(canvas).putImageData(shape, 0, 0);
  return canvas;
}

/** @param {OffscreenCanvas} canvas */
function contextOf(canvas) {
  return /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d'));
}
