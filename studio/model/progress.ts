// How far a run is, in words.

import { Countdown, type StageClock, timeLeft } from './stage-clock.js';
import { count, doing, remaining, seconds } from './words.js';
import type { State } from './store.js';

/** One run's progress. */
export class Progress {
  countdown = new Countdown();

  /**
   * @param headline that is shown by now
   * @returns what is to be shown; a new stage is also told
   */
  of(clock: StageClock, headline: string): Partial<State> {
    const stage = clock.current;
    if (!stage) return {};
    const name = doing(stage.id);
    const now = performance.now();
    const left = this.countdown.follow(timeLeft(clock, now), now);
    const words = [
      stage.total > 1 ? `${count(stage.done)} of ${count(stage.total)}` : '',
      `${seconds(clock.ms + now - clock.markedAt)} so far`,
      left === null ? '' : remaining(left),
    ];
    return {
      ...(headline === name ? {} : { headline: name, live: name }),
      subline: words.filter(Boolean).join(' · '),
      share: clock.share,
    };
  }
}
