/**
 * A video file as a source of frames. The browser's own player decodes; each frame is reached by seeking to the middle
 * of its time, which gives the same frames every time as long as the frame rate is constant.
 * @module
 */

import { Grabber } from './grabber.js';
import { PageError } from './words.js';

/** Taken when the browser does not tell when frames are shown. */
const USUAL_FPS = 30;

/** Frames watched to find the frame rate. */
const WATCHED = 12;

const SEEK_LIMIT_MS = 15_000;

/**
 * @param {File} file
 * @returns {Promise<import('./source.js').Source>}
 */
export async function openVideo(file) {
  const url = URL.createObjectURL(file);
  const video = document.createElement('video');
  Object.assign(video, { muted: true, playsInline: true, preload: 'auto', src: url });
  const close = () => {
    video.removeAttribute('src');
    video.load();
    URL.revokeObjectURL(url);
  };
  try {
    await once(video, 'loadeddata', 'unreadable-video', file.name);
    if (video.videoWidth === 0) throw new PageError('unreadable-video', `${file.name} has no picture`);
    const duration = await durationOf(video);
    const fps = await frameRate(video);
    return videoSource(video, { name: file.name, fps, count: Math.max(1, Math.round(duration * fps)), close });
  } catch (error) {
    close();
    throw error;
  }
}

/**
 * @param {HTMLVideoElement} video
 * @param {{name: string, fps: number, count: number, close: () => void}} facts
 * @returns {import('./source.js').Source}
 */
function videoSource(video, { name, fps, count, close }) {
  const grabber = new Grabber();
  const size = { width: video.videoWidth, height: video.videoHeight };
  /** @type {Promise<unknown>} */
  let last = Promise.resolve();
  // A player can be at one place only: whoever asks waits for the one before, also for one who no longer wants it.
  const frameAt = (/** @type {number} */ frame, /** @type {number} */ side) => {
    const next = last.then(async () => {
      await seek(video, (frame + 0.5) / fps);
      return grabber.grab(video, size, side);
    });
    last = next.catch(() => {});
    return next;
  };
  return {
    kind: 'video',
    name,
    ...size,
    fps,
    count,
    preview: frameAt,
    async *frames(take, signal) {
      for (let k = 0; k < take.frames; k++) {
        signal.throwIfAborted();
        yield await frameAt(take.start + k * take.step, take.side);
      }
    },
    close,
  };
}

/**
 * @param {HTMLVideoElement} video
 * @param {number} time seconds
 */
async function seek(video, time) {
  // Seeking to where it already is gives no event.
  const target = Math.min(time, Math.max(0, video.duration - 0.001));
  if (Math.abs(video.currentTime - target) < 1e-6 && video.readyState >= 2) return;
  video.currentTime = target;
  await once(video, 'seeked', 'stuck-video', `at ${target.toFixed(2)} s`);
}

/**
 * Files written by a recorder do not know how long they are until their end has been seen.
 *
 * @param {HTMLVideoElement} video
 * @returns {Promise<number>} seconds
 */
async function durationOf(video) {
  if (!Number.isFinite(video.duration)) {
    video.currentTime = 1e7;
    await once(video, 'durationchange', 'unreadable-video', 'of unknown length');
  }
  return Number.isFinite(video.duration) ? video.duration : 0;
}

/**
 * Plays the first frames and takes the time between them.
 *
 * @param {HTMLVideoElement} video
 * @returns {Promise<number>} frames per second
 */
async function frameRate(video) {
  if (typeof video.requestVideoFrameCallback !== 'function') return USUAL_FPS;
  /** @type {number[]} */
  const times = [];
  await new Promise((resolve) => {
    const limit = setTimeout(resolve, 1500);
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
  const gaps = times.slice(1).map((time, k) => time - times[k]);
  const least = Math.min(...gaps.filter((gap) => gap > 0.004));
  if (!Number.isFinite(least)) return USUAL_FPS;
  const single = gaps.filter((gap) => gap > 0.004 && gap < 1.5 * least);
  const fps = single.length / single.reduce((sum, gap) => sum + gap, 0);
  // Times are often rounded to milliseconds: 29.4 is 29.97.
  const common = [23.976, 24, 25, 29.97, 30, 50, 59.94, 60].find((rate) => Math.abs(rate - fps) < 0.015 * rate);
  return common ?? fps;
}

/**
 * @param {HTMLVideoElement} video
 * @param {string} event
 * @param {string} code of the error if the video fails or does not answer
 * @param {string} detail
 * @returns {Promise<void>}
 */
function once(video, event, code, detail) {
  return new Promise((resolve, reject) => {
    const fail = () => finish(() => reject(new PageError(code, [detail, video.error?.message].filter(Boolean).join(': '))));
    const succeed = () => finish(resolve);
    const limit = setTimeout(fail, SEEK_LIMIT_MS);
    const finish = (/** @type {() => void} */ settle) => {
      clearTimeout(limit);
      video.removeEventListener(event, succeed);
      video.removeEventListener('error', fail);
      settle();
    };
    video.addEventListener(event, succeed);
    video.addEventListener('error', fail);
  });
}
