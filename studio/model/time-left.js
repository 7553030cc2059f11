/** How much longer saving takes, from the frames that are through. @module */

import { Countdown } from './stage-clock.js';

/** Before that nothing is said, in milliseconds. */
const FIRST_MS = 2000;

/** Frames after the first that tell their pace: the first waits for encoders to start. */
const LEAST_FRAMES = 2;

export class TimeLeft {
  /** @param {number} now milliseconds */
  constructor(now) {
    this.begun = now;
    /** @type {{done: number, now: number} | null} */
    this.first = null;
    this.done = 0;
    this.total = 0;
    this.countdown = new Countdown();
  }

  /** @param {number} now */
  begin(now) {
    Object.assign(this, new TimeLeft(now));
  }

  /**
   * @param {{done: number, total: number}} progress of one work; one that has other frames, or fewer, is a new one
   * @param {number} now
   * @returns {number | null} milliseconds; null while nobody knows
   */
  after({ done, total }, now) {
    if (done < this.done || (this.total > 0 && total !== this.total)) this.begin(now);
    [this.done, this.total] = [done, total];
    if (done === 0 || total === 0) return null;
    this.first ??= { done, now };
    if (now - this.begun < FIRST_MS) return null;
    const since = done - this.first.done;
    const pace = since < LEAST_FRAMES ? (now - this.begun) / done : (now - this.first.now) / since;
    return this.countdown.follow(pace * (total - done), now);
  }
}
