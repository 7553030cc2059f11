/**
 * At which size results are saved: the source's, half of it, the computation's, or another. Frames are read
 * from the source again, one by one.
 * @module
 */

import { fitSize } from './library.js';
import { PageError } from './words.js';

/** @typedef {{width: number, height: number}} Size */
/** @typedef {'source' | 'half' | 'working' | 'own'} SizeName */

/** Times of one frame that was read twice may differ by so much, in seconds. */
const SLACK = 1e-6;

/** Shorter sides are of no use. */
export const LEAST_SIDE = 16;

/**
 * @param {import('./source.js').Source} source
 * @param {Size} working
 * @returns {{name: SizeName, label: string, side: number}[]} what there is to choose from; sizes that are alike once
 */
export function sizesOf(source, working) {
  const side = Math.max(source.width, source.height);
  const own = { name: /** @type {const} */ ('own'), label: 'Other…', side };
  /** @type {[SizeName, string, number][]} */
  const named = [
    ['source', 'As the source', side],
    ['half', 'Half of it', Math.round(side / 2)],
    ['working', 'As computed', Math.max(working.width, working.height)],
  ];
  const there = named.filter(
    ([, , one], k) => one >= LEAST_SIDE && named.findIndex(([, , other]) => other === one) === k,
  );
  const sizes = there.map(([name, words, one]) => {
    const { width, height } = fitSize(source, one);
    return { name, label: `${words}, ${width} × ${height}`, side: one };
  });
  return [...sizes, own];
}

/**
 * The frames of a result, at another size.
 *
 * @param {Pick<import('./job.js').AnyJob, 'source' | 'take'>} job
 * @param {{numFrames: number, times: ArrayLike<number> | null}} masks
 * @param {number} side the longer one, in pixels
 */
export function framesOf({ source, take }, { numFrames, times }, side) {
  return {
    /**
     * All of them, in order.
     *
     * @param {AbortSignal} signal
     */
    async *all(signal) {
      let t = 0;
      for await (const { frame, time } of source.frames({ ...take, frames: numFrames, side }, signal)) {
        if (time !== null && times && Math.abs(time - times[t]) > SLACK)
          throw new PageError('other-frames', `frame ${t + 1} is at ${time} s and was at ${times[t]} s`);
        t += 1;
        yield frame;
      }
    },
    /**
     * One of them.
     *
     * @param {number} t
     */
    one: (t) => source.preview(take.start + t * take.step, side, times?.[t]),
  };
}

/**
 * @param {{numFrames: number, times: ArrayLike<number> | null, end?: number | null}} masks
 * @param {number} fps where frames have no times
 * @returns {number} seconds from the first frame's begin to the last one's end, which lasts as long as the one before
 *   where nobody knows
 */
export function durationOf({ numFrames, times, end = null }, fps) {
  if (times && end !== null) return end - times[0];
  if (!times || numFrames < 2) return numFrames / fps;
  const last = times[numFrames - 1];
  return 2 * last - times[numFrames - 2] - times[0];
}
