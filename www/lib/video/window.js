// What is found in one window of a clip: `WindowResult`.

import { Result, restored } from '../result.js';

/**
 * One frame whose mask is settled: `index` counts the clip's frames, `t` those of the window; `labels` holds one byte
 * for each pixel.
 * @typedef {{readonly index: number, readonly t: number, readonly time: number, readonly labels:
 *   Uint8Array<ArrayBuffer>}} SettledFrame
 */

/**
 * @typedef {object} WindowFacts
 * @property {number} index
 * @property {string | null} [clip]
 * @property {number} shot
 * @property {number} firstFrame
 * @property {Float64Array<ArrayBuffer>} times
 * @property {number | null} end
 * @property {{from: number, to: number}} settled
 */

/**
 * What a window of a clip's frames gave: a `Result` whose frames are counted from the window's first, with labels that
 * mean the same object in every window of the shot.
 */
export class WindowResult extends Result {
  /**
   * @param {import('../engine.js').RawResult} raw
   * @param {import('../requests.js').Ask} ask
   * @param {WindowFacts} facts
   */
  constructor(raw, ask, facts) {
    super(raw, ask);
    /** Number of this window, from 0. @readonly */
    this.index = facts.index;
    /** The clip that its frames were said to be of; null where nothing was said. @readonly */
    this.clip = facts.clip ?? null;
    /** Number of the shot that it lies in, from 0: labels of one shot say nothing about another. @readonly */
    this.shot = facts.shot;
    /** Which of the clip's frames its first one is. @readonly */
    this.firstFrame = facts.firstFrame;
    /** The time of each of its frames, in seconds. @readonly */
    this.times = facts.times;
    /** When the last of them ends, in seconds; null where nothing says. @readonly */
    this.end = facts.end;
    /**
     * The frames, `from <= t < to`, whose masks are settled by this window. Windows overlap; the masks of frames
     * outside of this range are better in the window before or after, which sees more of what goes on around them.
     * @readonly
     */
    this.settled = facts.settled;
    /** Bytes of memory that the engine held at the end of this window. @readonly */
    this.memoryBytes = raw.info.memoryBytes;
  }

  /**
   * A window's result that was saved.
   * @param {string | object} json as of `Result.fromJSON`
   * @returns {WindowResult}
   */
  static fromJSON(json) {
    const needed = ['trajectories', 'clusters', 'edgeTable', 'settled', 'firstFrame'];
    return restored(json, needed, (raw, ask, facts) => new WindowResult(raw, ask, facts));
  }

  /**
   * The settled frames: over all windows, each frame of the clip once and in order.
   * @returns {Generator<SettledFrame, void, undefined>}
   */
  *frames() {
    for (let t = this.settled.from; t < this.settled.to; t += 1) {
      yield { index: this.firstFrame + t, t, time: /** @type {number} */ (this.times[t]), labels: this.labels(t) };
    }
  }
}
