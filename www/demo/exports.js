/** What can be saved of a result: what it is called, what it is, and how it is made. @module */

/**
 * What there is to save.
 *
 * @typedef {object} Subject
 * @property {any} library the tracecut package
 * @property {{width: number, height: number, numFrames: number, labels: (t: number) => Uint8Array, times: ArrayLike<number> | null}} masks
 * @property {() => Iterable<CanvasImageSource> | AsyncIterable<CanvasImageSource>} frames
 * @property {number} frame on screen
 * @property {(object: number) => boolean} objects which are meant
 * @property {string} name of the clip
 * @property {number} fps where frames have no times
 * @property {() => string} tracks the trajectories as a track file
 */

/** @typedef {{signal: AbortSignal, onProgress: (progress: {done: number, total: number}) => void}} Work */

/**
 * @typedef {object} Choice
 * @property {string} id
 * @property {string} label of its button
 * @property {string} [says] to screen readers, where the label is short
 * @property {(subject: Subject) => string} file what is added to the clip's name
 * @property {(subject: Subject, work: Work) => Promise<Blob>} make
 */

/** @typedef {{title: string, about: string, choices: Choice[]}} Export */

/** The green of screens. */
const GREEN = '#00b140';

/** @type {Export[]} */
export const EXPORTS = [
  {
    title: 'Overlay video',
    about: 'The clip with the masks drawn over it.',
    choices: [video('overlay-webm', 'WebM', 'overlay', 'webm'), video('overlay-mp4', 'MP4', 'overlay', 'mp4')],
  },
  {
    title: 'Cut-out video',
    about: 'The objects alone, for an editor: on a transparent or on a green ground.',
    choices: [
      video('cutout-webm', 'Transparent WebM', 'cutout', 'webm', 'transparent'),
      video('cutout-mp4', 'Green MP4', 'cutout', 'mp4', GREEN),
    ],
  },
  {
    title: 'Masks of all frames',
    about: 'A ZIP of PNG files in the colours of the page, or a folder of black and white ones for each object. Times are in masks.json.',
    choices: [
      { id: 'zip', label: 'ZIP, in colours', file: () => 'masks.zip', make: zip(false) },
      { id: 'zip-objects', label: 'ZIP, by object', file: () => 'objects.zip', make: zip(true) },
    ],
  },
  {
    title: 'Mask of this frame',
    about: 'One PNG in the colours of the page.',
    choices: [
      {
        id: 'png',
        label: 'PNG',
        says: 'Mask of this frame as PNG',
        file: ({ frame }) => `mask-${String(frame + 1).padStart(4, '0')}.png`,
        make: async ({ library, masks, frame, objects }) => {
          const labels = masks.labels(frame).map((label) => (objects(label) ? label : 0));
          return new Blob([await library.maskPng({ ...masks, labels: () => labels }, frame)], { type: 'image/png' });
        },
      },
    ],
  },
  {
    title: 'Data',
    about: 'COCO run lengths for annotation tools; trajectories with their labels for the Moseg benchmark.',
    choices: [
      {
        id: 'coco',
        label: 'COCO JSON',
        file: () => 'coco.json',
        make: async ({ library, masks, objects, name, fps }) =>
          json(library.cocoRle(masks, { objects, video: name, ...(masks.times ? {} : { frameRate: fps }) })),
      },
      { id: 'tracks', label: 'tracks.dat', file: () => 'tracks.dat', make: async ({ tracks }) => new Blob([tracks()], { type: 'text/plain' }) },
    ],
  },
];

/**
 * @param {string} id
 * @param {string} label
 * @param {'overlay' | 'cutout'} style
 * @param {'webm' | 'mp4'} format
 * @param {string} [background]
 * @returns {Choice}
 */
function video(id, label, style, format, background) {
  return {
    id,
    label,
    says: `${style === 'overlay' ? 'Overlay' : 'Cut-out'} video as ${label}`,
    file: () => `${style}.${format}`,
    make: ({ library, masks, frames, objects, fps }, work) =>
      library.encodeVideo(masks, frames(), {
        style, format, objects, ...work, ...(background ? { background } : {}), ...(masks.times ? {} : { frameRate: fps }),
      }),
  };
}

/**
 * @param {boolean} perObject
 * @returns {Choice['make']}
 */
function zip(perObject) {
  return async ({ library, masks, objects, fps }, work) => {
    const bytes = await library.masksZip(masks, { perObject, objects, ...work, ...(masks.times ? {} : { frameRate: fps }) });
    return new Blob([bytes], { type: 'application/zip' });
  };
}

/** @param {unknown} value */
function json(value) {
  return new Blob([JSON.stringify(value)], { type: 'application/json' });
}

/**
 * @param {string} name of a clip
 * @returns {string} what files made of it begin with: no extension, nothing that a file system minds
 */
export function stemOf(name) {
  const stem = name.replace(/ … .*$/, '').replace(/\.[a-z0-9]{2,5}$/i, '').replace(/[^\p{L}\p{N}._-]+/gu, '-').replace(/^[-.]+|[-.]+$/g, '');
  return (stem || 'clip').slice(0, 80).toLowerCase();
}
