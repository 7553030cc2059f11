// How much longer saving takes, from the frames that are through.

import { Countdown } from './stage-clock.js';

/** Before that nothing is said, in milliseconds. */
const FIRST_MS = 2000;

/** Frames after the first that tell their pace: the first waits for encoders to start. */
const LEAST_FRAMES = 2;

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

  begin(now: number) {
    Object.assign(this, new TimeLeft(now));
  }

  /**
   * @param progress of one work; one that has other frames, or fewer, is a new one
   * @returns milliseconds; null while nobody knows
   */
  after({ done, total }: { done: number; total: number }, now: number): number | null {
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
