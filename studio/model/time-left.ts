// Estimates how long saving takes from the finished frames.

import { Countdown } from './stage-clock.js';

/** Time before the first estimate, in milliseconds; chosen by eye. */
const MIN_ELAPSED_MS = 2000;

/** Frames after the first that give a pace; the first waits for the encoder. */
const MIN_PACE_FRAMES = 2;

export class TimeLeft {
  begun: number;
  first: { done: number; now: number } | null = null;
  done = 0;
  total = 0;
  countdown = new Countdown();

  /** @param now milliseconds */
  constructor(now: number) {
    this.begun = now;
  }

  restart(now: number) {
    Object.assign(this, new TimeLeft(now));
  }

  /**
   * Updates the estimate. A different total or a smaller count starts again.
   * @returns milliseconds; null if too early
   */
  estimate({ done, total }: { done: number; total: number }, now: number): number | null {
    if (done < this.done || (this.total > 0 && total !== this.total)) this.restart(now);
    [this.done, this.total] = [done, total];
    if (done === 0 || total === 0) return null;
    this.first ??= { done, now };
    if (now - this.begun < MIN_ELAPSED_MS) return null;
    const since = done - this.first.done;
    const pace = since < MIN_PACE_FRAMES ? (now - this.begun) / done : (now - this.first.now) / since;
    return this.countdown.follow(pace * (total - done), now);
  }
}
