// Frames by seeking a video element: slower than WebCodecs, but it plays whatever the browser plays. Where the player
// tells which frame it shows, that is checked; where it does not, frames are exact as long as all last equally long and
// the machine is not too busy.

import { TraceCutError } from '../check/errors.js';
import { toRawFrame } from '../worker/frames.js';

/**
 * @typedef {object} SeekOptions
 * @property {Float64Array | null} times of all frames, from the container; null where it could not be read
 * @property {string | null} codec
 */

/**
 * Frames of a file that a hidden video element loads.
 * @param {URL} url
 * @param {SeekOptions & {release?: () => void}} options
 * @returns {Promise<import('./reader.js').Reader>}
 */
export async function openSeeking(url, { times, codec, release }) {
  if (typeof document === 'undefined') {
    release?.();
    throw new TraceCutError(
      'unsupported',
      `a worker has no video element to fall back to for ${codec ?? 'this file'}; open it in the page`,
    );
  }
  const video = document.createElement('video');
  Object.assign(video, { muted: true, playsInline: true, preload: 'auto' });
  if (/^https?:/.test(url.protocol) && url.origin !== location.origin) video.crossOrigin = 'anonymous';
  video.src = url.href;
  const close = () => {
    video.removeAttribute('src');
    video.load();
    release?.();
  };
  try {
    await until(video, 'loadeddata', () => unplayable(video, codec));
    return await seekingReader(video, { times, codec }, close);
  } catch (error) {
    close();
    throw error;
  }
}

/**
 * Frames of a video element of the caller's, which is where it was before once the reader is closed.
 * @param {HTMLVideoElement} video
 * @param {SeekOptions} options
 * @returns {Promise<import('./reader.js').Reader>}
 */
export async function openElement(video, options) {
  const { currentTime, paused, muted, playbackRate, loop } = video;
  const putBack = () => {
    video.pause();
    Object.assign(video, { muted, playbackRate, loop, currentTime });
    if (!paused) video.play().catch(() => {});
  };
  try {
    if (video.readyState < 2) await until(video, 'loadeddata', () => unplayable(video, options.codec));
    video.pause();
    Object.assign(video, { muted: true, loop: false });
    return await seekingReader(video, options, putBack);
  } catch (error) {
    putBack();
    throw error;
  }
}

/**
 * @param {HTMLVideoElement} video
 * @param {SeekOptions} options
 * @param {() => void} close
 * @returns {Promise<import('./reader.js').Reader>}
 */
async function seekingReader(video, { times, codec }, close) {
  // Some players play the sound alone where they have no decoder for the pictures.
  if (video.videoWidth === 0)
    throw codec ? unplayable(video, codec) : new TraceCutError('no-video', 'the file has no video track, only sound');
  const duration = await durationOf(video);
  const fps =
    times && times.length > 1
      ? (times.length - 1) / (at(times, times.length - 1) - at(times, 0))
      : await frameRate(video);
  const known = times ?? Float64Array.from({ length: Math.max(1, Math.round(duration * fps)) }, (_, k) => k / fps);
  const { videoWidth: width, videoHeight: height } = video;
  return {
    async info() {
      return { width, height, duration, frameRate: fps, numFrames: known.length, codec, decodable: true };
    },
    frames: ({ start, end }) => soughtFrames(video, known, 1 / fps, { start, end }),
    times: async () => known,
    close,
  };
}

/**
 * Where in a frame's time to seek to, one after the other until the player shows that frame: far from both its
 * neighbours, and late, since a browser may take the one before for longer than it is.
 */
const WITHIN = [0.75, 0.9, 0.6];

/**
 * How long a player may take to tell which frame it shows, in milliseconds. Some never tell, of elements that are not
 * on the screen.
 */
const TELLS_MS = 250;

/** A player that has been silent, or at odds with the container, so often is not asked again. */
const DOUBTS = 3;

/**
 * @param {HTMLVideoElement} video
 * @param {Float64Array} times
 * @param {number} usual seconds that the last frame is taken to last
 * @param {{start: number, end: number}} range
 * @returns {AsyncGenerator<import('./reader.js').TimedFrame, void, unknown>}
 */
async function* soughtFrames(video, times, usual, { start, end }) {
  const player = { doubts: 0 };
  for (let k = 0; k < times.length; k += 1) {
    const time = at(times, k);
    if (time < start - usual) continue;
    if (time > end) return;
    const duration = k + 1 < times.length ? at(times, k + 1) - time : usual;
    yield {
      time,
      duration,
      async read() {
        await show(video, time, duration, player);
        return readElement(video);
      },
      close() {},
    };
  }
}

/**
 * Seeks to a frame until the player says that it shows it.
 * @param {HTMLVideoElement} video
 * @param {number} time when the frame begins, in seconds
 * @param {number} duration
 * @param {{doubts: number}} player
 */
async function show(video, time, duration, player) {
  for (const within of WITHIN) {
    const asked = player.doubts < DOUBTS && typeof video.requestVideoFrameCallback === 'function';
    const shown = asked ? shownTime(video) : null;
    const moved = await seek(video, time + within * duration);
    if (!shown || !moved) return;
    const told = await shown;
    if (told !== null && Math.abs(told - time) < duration / 2) {
      player.doubts = 0;
      return;
    }
    if (told === null) break;
  }
  player.doubts += 1;
}

/**
 * The time of the next frame that the player shows; null if it does not tell.
 * @param {HTMLVideoElement} video
 * @returns {Promise<number | null>}
 */
function shownTime(video) {
  return new Promise((resolve) => {
    const handle = video.requestVideoFrameCallback((_now, { mediaTime }) => {
      clearTimeout(limit);
      resolve(mediaTime);
    });
    const limit = setTimeout(() => {
      video.cancelVideoFrameCallback(handle);
      resolve(null);
    }, TELLS_MS);
  });
}

/**
 * @param {HTMLVideoElement} video
 * @param {number} time seconds
 * @returns {Promise<boolean>} whether it was not there already
 */
async function seek(video, time) {
  const target = Math.min(time, Math.max(0, video.duration - 0.001));
  // Seeking to where it already is gives no event.
  if (Math.abs(video.currentTime - target) < 1e-6 && video.readyState >= 2 && !video.seeking) return false;
  video.currentTime = target;
  const stuck = () =>
    new TraceCutError('truncated', `the player does not get to ${target.toFixed(2)} s: the file is cut off or damaged`);
  await until(video, 'seeked', stuck);
  return true;
}

/** @param {HTMLVideoElement} video */
async function readElement(video) {
  try {
    return await toRawFrame(video, () => Promise.reject(new Error('no file')));
  } catch (error) {
    if (!(error instanceof DOMException) || error.name !== 'SecurityError') throw error;
    const words =
      'the video comes from another site, which has to let its pixels be read (Access-Control-Allow-Origin, and crossOrigin set)';
    throw new TraceCutError('unsupported', words, { cause: error });
  }
}

/**
 * Files written by a recorder do not know how long they are until their end has been seen.
 * @param {HTMLVideoElement} video
 * @returns {Promise<number>} seconds
 */
async function durationOf(video) {
  if (!Number.isFinite(video.duration)) {
    video.currentTime = 1e7;
    await until(video, 'durationchange', () => new TraceCutError('truncated', 'the video does not say how long it is'));
  }
  return Number.isFinite(video.duration) ? video.duration : 0;
}

/**
 * @param {HTMLVideoElement} video
 * @param {string | null} codec
 */
function unplayable(video, codec) {
  const detail = video.error?.message ? ` (${video.error.message})` : '';
  if (codec === null) {
    return new TraceCutError(
      'no-video',
      `this is no video that the browser can play${detail}; convert it to MP4 (H.264) or WebM`,
    );
  }
  return new TraceCutError(
    'codec',
    `the codec ${codec} cannot be decoded by this browser${detail}; convert it to ${/^avc/.test(codec) ? '' : 'MP4 (H.264) or '}WebM`,
  );
}

/**
 * @param {Float64Array} values
 * @param {number} index
 */
function at(values, index) {
  return values[index] ?? NaN;
}

/** A player that says nothing for so long will say nothing more. */
const LIMIT_MS = 15_000;

/** Taken when the browser does not tell when frames are shown. */
const USUAL_FPS = 30;

/** Frames watched to find the frame rate. */
const WATCHED = 12;

/** What cameras and programs write. */
const COMMON_FPS = [23.976, 24, 25, 29.97, 30, 50, 59.94, 60];

/**
 * Resolves at the event; rejects with the error of `fault` when the element fails or stays silent.
 * @param {HTMLVideoElement} video
 * @param {string} event
 * @param {() => Error} fault
 * @returns {Promise<void>}
 */
export function until(video, event, fault) {
  return new Promise((resolve, reject) => {
    const finish = (/** @type {() => void} */ settle) => {
      clearTimeout(limit);
      video.removeEventListener(event, succeed);
      video.removeEventListener('error', fail);
      settle();
    };
    const succeed = () => finish(() => resolve());
    const fail = () => finish(() => reject(fault()));
    const limit = setTimeout(fail, LIMIT_MS);
    video.addEventListener(event, succeed);
    video.addEventListener('error', fail);
    if (video.error) fail();
  });
}

/**
 * Plays the first frames and takes the time between them.
 * @param {HTMLVideoElement} video
 * @returns {Promise<number>} frames per second
 */
export async function frameRate(video) {
  if (typeof video.requestVideoFrameCallback !== 'function') return USUAL_FPS;
  /** @type {number[]} */
  const times = [];
  await new Promise((/** @type {(value: unknown) => void} */ resolve) => {
    const limit = setTimeout(resolve, 1500, undefined);
    const watch = (/** @type {number} */ _now, /** @type {{mediaTime: number}} */ { mediaTime }) => {
      times.push(mediaTime);
      if (times.length < WATCHED) video.requestVideoFrameCallback(watch);
      else {
        clearTimeout(limit);
        resolve(undefined);
      }
    };
    video.requestVideoFrameCallback(watch);
    video.addEventListener('ended', resolve, { once: true });
    video.play().catch(resolve);
  });
  video.pause();
  return rateOf(times);
}

/**
 * @param {number[]} times of frames in seconds; some frames may be missing between them
 * @returns {number} frames per second
 */
export function rateOf(times) {
  const gaps = times.slice(1).map((time, k) => time - /** @type {number} */ (times[k]));
  const least = Math.min(...gaps.filter((gap) => gap > 0.004));
  if (!Number.isFinite(least)) return USUAL_FPS;
  const single = gaps.filter((gap) => gap > 0.004 && gap < 1.5 * least);
  const fps = single.length / single.reduce((sum, gap) => sum + gap, 0);
  // Times are often rounded to milliseconds: 29.4 is 29.97.
  return COMMON_FPS.find((rate) => Math.abs(rate - fps) < 0.015 * rate) ?? fps;
}
