// How far a run is, in words.

import { Countdown, type StageClock, timeLeft } from './stage-clock.js';
import { formatCount, stageName, formatTimeLeft, formatSeconds } from './messages.js';
import type { State } from './store.js';

/** One run's progress. */
export class Progress {
  countdown = new Countdown();

  /**
   * @param headline that is shown by now
   * @returns what is to be shown; a new stage is also told
   */
  patch(clock: StageClock, headline: string): Partial<State> {
    const stage = clock.current;
    if (!stage) return {};
    const name = stageName(stage.id);
    const now = performance.now();
    const msLeft = this.countdown.follow(timeLeft(clock, now), now);
    const parts = [
      stage.total > 1 ? `${formatCount(stage.done)} of ${formatCount(stage.total)}` : '',
      `${formatSeconds(clock.ms + now - clock.markedAt)} so far`,
      msLeft === null ? '' : formatTimeLeft(msLeft),
    ];
    return {
      ...(headline === name ? {} : { headline: name, announcement: name }),
      subline: parts.filter(Boolean).join(' · '),
      share: clock.share,
    };
  }
}
