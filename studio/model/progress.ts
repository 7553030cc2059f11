// Progress of a run as text.

import { Countdown, type StageClock, timeLeft } from './stage-clock.js';
import { formatCount, stageName, formatTimeLeft, formatSeconds } from './messages.js';
import type { State } from './store.js';

/** Formats the progress of one run. */
export class Progress {
  countdown = new Countdown();

  /**
   * @param headline on screen
   * @returns changes of the state; a new stage is also announced
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
