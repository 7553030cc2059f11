/** What an export is, and what it is made of. @module */

/** @typedef {import('../run/job.js').Library} Library */

/**
 * What there is to save.
 *
 * @typedef {object} Subject
 * @property {Library} library
 * @property {{width: number, height: number, numFrames: number, labels: (t: number) => Uint8Array, times:
 *   ArrayLike<number> | null}} masks
 * @property {() => AsyncIterable<ImageBitmap>} frames
 * @property {(t: number) => Promise<ImageBitmap>} image a frame, at clip size
 * @property {((t: number) => Promise<import('../layers/layer.js').Plate>) | null} plate the scene of a frame without the
 *   objects, which may be smaller; null where nobody knows
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
 * @property {(subject: Omit<Subject, 'objects'>) => boolean} [there] whether it can be made; always if not said
 * @property {(subject: Subject, work: Work) => Promise<Blob>} make
 */

/** @typedef {{title: string, about: string, choices: Choice[]}} Export */

/**
 * @param {import('../store.js').State} state
 * @param {Library} library
 * @returns {Omit<Subject, 'objects'> | null} null without masks
 */
export function subjectOf({ found, job, film, frame }, library) {
  const points = found?.points;
  if (!points?.hasMasks || !job) return null;
  const { width, height, numFrames } = points.result;
  const labels = (/** @type {number} */ t) => /** @type {Uint8Array} */ (points.mask(t));
  return {
    library,
    masks: { width, height, numFrames, labels, times: film.times.seconds?.slice(0, numFrames) ?? null },
    frames: () => job.images,
    image: async (/** @type {number} */ t) => /** @type {ImageBitmap} */ (await job.images.open(t)),
    plate: found?.answers.background ?? null,
    frame,
    name: job.source.name,
    fps: film.fps,
    tracks: () => points.result.toTracksDat(),
  };
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
