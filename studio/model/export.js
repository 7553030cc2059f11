/** What an export is, and what it is made of. @module */

import { masksAtSize } from './library.js';

/**
 * What there is to save.
 *
 * @typedef {object} Subject
 * @property {{width: number, height: number, numFrames: number, labels: (t: number) => Uint8Array, times:
 *   ArrayLike<number> | null, end: number | null, shots: {first: number, last: number}[]}} masks
 * @property {(signal: AbortSignal) => AsyncIterable<ImageData>} frames all frames, at the size that is wanted
 * @property {(t: number) => Promise<ImageData>} image one of them
 * @property {Look} look of the masks on screen
 * @property {import('./library.js').VideoQuality} quality of videos
 * @property {import('./library.js').MaskEdges} edges of the masks on screen
 * @property {import('./library.js').Ground} ground of cut-out objects on screen
 * @property {(format: 'webm' | 'mp4') => import('./library.js').SoundOptions | null} sound of videos; null for none
 * @property {import('./source.js').Source} source
 * @property {((t: number) => Promise<import('./answers.js').Plate>) | null} plate the scene of a frame without the
 *   objects, which may be smaller; null where nobody knows
 * @property {number} frame on screen
 * @property {(object: number) => boolean} objects which are meant
 * @property {string} name of the clip
 * @property {number} fps where frames have no times
 * @property {() => string | Promise<string>} tracks the trajectories as a track file
 * @property {import('./library.js').TrajectoryPoints} points of the trajectories, in pixels of the masks
 * @property {import('./store.js').State} state of the page
 */

/**
 * How masks look on screen: how opaque they are as a whole, and their fill, 0 to 1; how wide their outline is, in
 * pixels of the picture that is saved.
 *
 * @typedef {{opacity: number, fill: number, outline: number}} Look
 */

/** What there is to save, before it is known how. @typedef {Omit<Subject, 'objects' | 'frames' | 'image' | 'look' |
 * 'quality' | 'sound' | 'ground' | 'edges'>} Found
 */

/** @typedef {{signal: AbortSignal, onProgress: (progress: {done: number, total: number}) => void}} Work */

/**
 * @typedef {object} Choice
 * @property {string} id
 * @property {string | ((ground: import('./look.js').GroundName) => string)} label of its button; that of a
 *   cut-out names the ground on screen
 * @property {string} [says] to screen readers, where the label is short
 * @property {(subject: Subject) => string} file what is added to the clip's name
 * @property {(subject: Found) => boolean} [there] whether it can be made; always if not said
 * @property {string} [type] of a file that is written while it is made
 * @property {(subject: Subject, work: Work) => Promise<Blob | ReadableStream<Uint8Array<ArrayBuffer>>>} make
 */

/** @typedef {{title: string, about: string, choices: Choice[]}} Export */

/**
 * @param {import('./store.js').State} state
 * @returns {Found | null} null without masks
 */
export function subjectOf(state) {
  const { found, job, film, frame } = state;
  const points = found?.points;
  if (!points || !job) return null;
  const { width, height, numFrames } = points.result;
  const labels = (/** @type {number} */ t) => /** @type {Uint8Array} */ (points.mask(t));
  return {
    masks: {
      width,
      height,
      numFrames,
      labels,
      times: film.times.seconds?.slice(0, numFrames) ?? null,
      end: endOf(film, numFrames),
      shots: shotsOf(film, numFrames),
    },
    source: job.source,
    plate: found?.answers.background ?? null,
    frame,
    name: job.source.name,
    fps: film.fps,
    tracks: () => points.result.toTracksDat(),
    points: points.result.trajectories,
    state,
  };
}

/**
 * @param {import('./store.js').Film} film
 * @param {number} numFrames of the result
 * @returns {{first: number, last: number}[]} stretches without a cut
 */
export function shotsOf({ cuts }, numFrames) {
  const starts = [0, ...cuts.filter((cut) => cut < numFrames)];
  return starts.map((first, k) => ({ first, last: (starts[k + 1] ?? numFrames) - 1 }));
}

/**
 * @param {import('./store.js').Film} film
 * @param {number} numFrames of the result
 * @returns {number | null} when the last of them ends, in seconds; null where nobody knows
 */
function endOf({ times }, numFrames) {
  return times.seconds?.[numFrames] ?? times.end;
}

/**
 * @param {Subject} subject
 * @param {Work} work
 * @returns {Promise<import('./library.js').MaskSource>} all masks, at the size that is wanted
 */
export function masksOf({ masks, frames, edges }, work) {
  return masksAtSize(masks, frames(work.signal), { ...work, edges });
}

/**
 * @param {Subject} subject
 * @param {number} t
 * @param {ImageData} frame that frame, at the size that is wanted
 * @returns {Promise<Uint8Array>} its labels at that size
 */
export async function labelsOf({ masks, edges }, t, frame) {
  const one = { ...masks, numFrames: 1, times: null, end: null, shots: [], labels: () => masks.labels(t) };
  return (await masksAtSize(one, [frame], { edges })).labels(0);
}

/**
 * @param {Subject} subject
 * @returns {{frameRate?: number}} the option that takes the place of times
 */
export function rateOf({ masks, fps }) {
  return masks.times ? {} : { frameRate: fps };
}

/**
 * @param {string} name of a clip
 * @returns {string} what files made of it begin with: no extension, nothing that a file system minds
 */
export function stemOf(name) {
  const stem = name
    .replace(/ … .*$/, '')
    .replace(/\.[a-z0-9]{2,5}$/i, '')
    .replace(/[^\p{L}\p{N}._-]+/gu, '-')
    .replace(/^[-.]+|[-.]+$/g, '');
  return (stem || 'clip').slice(0, 80).toLowerCase();
}
