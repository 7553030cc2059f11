/** When each frame is shown: in seconds where the clip has a clock, else by the number of the image. @module */

export class Times {
  /**
   * @param {ArrayLike<number> | null} seconds of each frame since the beginning of the clip; null where nobody knows
   */
  constructor(seconds) {
    this.seconds = seconds;
  }

  /**
   * @param {import('./source.js').Source} source
   * @param {import('./source.js').Take} take
   * @returns {Times}
   */
  static of(source, take) {
    if (source.kind === 'images') return new Times(null);
    return new Times(Float64Array.from({ length: take.frames }, (_, k) => (take.start + k * take.step) / source.fps));
  }

  /**
   * @param {number} frame
   * @returns {string} `0.8 s`, `frame 13`
   */
  at(frame) {
    return this.seconds ? `${clock(this.seconds[frame])}\u00a0s` : `frame ${frame + 1}`;
  }

  /**
   * @param {number} first
   * @param {number} last
   * @returns {string} `0.0–1.6 s`, `frames 1–9`
   */
  span(first, last) {
    if (!this.seconds) return first === last ? this.at(first) : `frames ${first + 1}–${last + 1}`;
    return `${clock(this.seconds[first])}–${clock(this.seconds[last])}\u00a0s`;
  }
}

/** @param {number} seconds */
function clock(seconds) {
  return (seconds ?? 0).toFixed(1);
}
