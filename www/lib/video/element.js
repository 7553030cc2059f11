// Waiting for a video element, and finding out how many frames it shows a second.

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
