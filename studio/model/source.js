/** Where frames come from: each kind of source answers the same questions, so the rest of the page does not care. @module */

/**
 * What to take from a source.
 *
 * @typedef {object} Take
 * @property {number} start index of the first frame
 * @property {number} frames how many
 * @property {number} step 1 takes every frame, 2 every second one, …
 * @property {number} side long side of the working size in pixels; a smaller source stays as it is
 */

/**
 * @typedef {object} Source
 * @property {'sample' | 'video' | 'images' | 'still'} kind
 * @property {string} name
 * @property {number} width in pixels
 * @property {number} height
 * @property {number} fps frames per second, on average; a convention for images
 * @property {number} count frames there are (for a video: about)
 * @property {(frame: number, side: number, time?: number) => Promise<ImageData>} preview one frame; found by its time in
 *   seconds where that is known
 * @property {(count: number, side: number, signal: AbortSignal) => AsyncIterable<ImageData>} [strip] `count` frames, or
 *   all where there are fewer, evenly spread, of at most this long side; what cannot be trimmed has none
 * @property {ArrayLike<number> | null} [times] of all frames in seconds, where the file says them
 * @property {number} [end] when the last frame ends, in seconds, where the file says it
 * @property {{frames: number, total: number | null} | null} [damage] what `frames` ended with when it was last read:
 *   `frames` come before the damage, of `total`
 * @property {File} [file] the file of a video
 * @property {string} [type] its media type, by its content
 * @property {File[]} [files] all that it was opened from; the sample has none
 * @property {(take: Take, signal: AbortSignal) => AsyncIterable<{frame: ImageData, time: number | null, end?:
 *   number | null}>} frames with their times, and when they end, in seconds; null where nothing says
 * @property {(take: Take) => {source: File, options: import('./library.js').VideoOptions}} [direct] what `segmentVideo` reads
 *   by itself; of other sources it is given `frames`
 * @property {() => void} close
 */

/** What is taken when nobody chooses, of as many frames as there are. @type {Take} */
export const DEFAULT_TAKE = { start: 0, frames: 2, step: 1, side: 480 };

/**
 * @param {Source | null} source
 * @returns {'clip' | 'still'} whether it has motion
 */
export function kindOf(source) {
  return source?.kind === 'still' ? 'still' : 'clip';
}

/**
 * @param {Source} source
 * @returns {Take} what is taken of it when nobody chooses
 */
export function usualTake(source) {
  const side = source.kind === 'sample' ? source.width : DEFAULT_TAKE.side;
  return fitTake({ ...DEFAULT_TAKE, frames: source.count, side }, source);
}

/**
 * @param {Take} take
 * @param {Source} source
 * @returns {Take} within what the source has
 */
export function fitTake(take, source) {
  const start = Math.max(0, Math.min(take.start, source.count - 2));
  const room = Math.floor((source.count - 1 - start) / take.step) + 1;
  return { ...take, start, frames: Math.max(1, Math.min(take.frames, room)) };
}

/**
 * @param {Source} source
 * @param {number} frame
 * @returns {number} when it begins, in seconds
 */
export function timeOf({ times, fps }, frame) {
  return times?.[frame] ?? frame / fps;
}

/**
 * @param {Source} source
 * @returns {number} when its last frame ends, in seconds
 */
export function endOf({ count, fps, end = count / fps }) {
  return end;
}
