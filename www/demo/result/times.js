/** When each frame is shown: in seconds where the clip has a clock, else by the number of the image. @module */

import { say } from '../language.js';

export class Times {
  /**
   * @param {number[] | null} seconds of each frame since the beginning of the clip; null where nobody knows
   * @param {number | null} [end] of the last frame, in seconds; null where nobody knows
   */
  constructor(seconds, end = null) {
    this.seconds = seconds;
    this.end = seconds && end;
  }

  /**
   * How long a frame is shown: until the next; the last until the clip's end, or as long as the one before.
   *
   * @param {number} frame
   * @param {number} fps where nobody knows
   * @returns {number} in seconds
   */
  lasts(frame, fps) {
    const { seconds, end } = this;
    if (seconds && end !== null && frame === seconds.length - 1) return end - seconds[frame];
    const from = Math.min(frame, (this.seconds?.length ?? 0) - 2);
    return this.seconds && from >= 0 ? this.seconds[from + 1] - this.seconds[from] : 1 / fps;
  }

  /**
   * @param {number} frame
   * @returns {string} `0.8 s`, `frame 13`
   */
  at(frame) {
    const seconds = this.seconds?.[frame];
    return seconds === undefined ? say`frame ${frame + 1}` : `${clock(seconds)}\u00a0s`;
  }

  /**
   * @param {number} first
   * @param {number} last
   * @returns {string} `0.0–1.6 s`, `frames 1–9`
   */
  span(first, last) {
    if (!this.seconds) return first === last ? this.at(first) : say`frames ${first + 1}–${last + 1}`;
    return `${clock(this.seconds[first])}–${clock(this.seconds[last])}\u00a0s`;
  }
}

/** @param {number} seconds */
function clock(seconds) {
  return seconds.toFixed(1);
}
