// Presentation times: mends those that are missing or do not increase, and gives each picture its duration.

/** Seconds that a picture is shown where its file does not say. */
const DEFAULT_DURATION_S = 1 / 25;

/**
 * A decoded picture, with what its file says of its time in seconds, null where it says nothing.
 * @typedef {{frame: import('../worker/frames.js').PixelFrame, time: number | null, duration: number | null}} Picture
 */

/** @typedef {import('./raw.js').FileFrame} FileFrame */

/** Gives the pictures of a file their times, as docs/frames.md tells. Each is held until the next one is there. */
export class Timeline {
  /** @type {Picture | null} */
  #held = null;
  /** @type {{time: number, duration: number} | null} */
  #last = null;
  /** Number of frames given so far. */
  numGiven = 0;

  /**
   * Takes the next picture, null after the last, and gives the frame before it; null where there is none.
   * @param {Picture | null} next
   * @returns {FileFrame | null}
   */
  take(next) {
    const picture = this.#held;
    this.#held = next;
    if (!picture || isBeforeStart(picture, next)) return null;
    this.#last = this.#timeOf(picture, next);
    this.numGiven += 1;
    return { frame: picture.frame, index: this.numGiven - 1, ...this.#last };
  }

  /**
   * @param {Picture} picture
   * @param {Picture | null} next
   */
  #timeOf(picture, next) {
    const last = this.#last;
    const following = last ? last.time + last.duration : 0;
    const time = picture.time !== null && picture.time > (last?.time ?? -Infinity) ? picture.time : following;
    const known = picture.duration || last?.duration || DEFAULT_DURATION_S;
    const isFollowed = next !== null && next.time !== null && next.time > time;
    return { time, duration: isFollowed ? Number(next.time) - time : known };
  }
}

/**
 * Returns true if a picture ends at or before zero, where players begin.
 * @param {Picture} picture
 * @param {Picture | null} next
 */
function isBeforeStart({ time, duration }, next) {
  if (time === null || time >= 0) return false;
  const end = next ? next.time : time + (duration ?? 0);
  return end !== null && end <= 0;
}
