/** What is shown while a run is under way: stage, share, time so far and time left. @module */

import { Countdown, timeLeft } from '../run/stage-clock.js';
import { count, remaining, seconds } from '../words.js';
import { stagesOf } from './stages.js';
import { say } from '../language.js';

/** @typedef {import('../run/stage-clock.js').StageClock} StageClock */

/** One run's progress. */
export class Progress {
  constructor() {
    this.countdown = new Countdown();
  }

  /**
   * @param {StageClock} clock
   * @param {string} headline that is shown by now
   * @returns {Partial<import('../store.js').State>} what is to be shown; a new stage is also told
   */
  of(clock, headline) {
    const stage = clock.current;
    if (!stage) return {};
    const name = say(stage.name);
    const now = performance.now();
    const left = this.countdown.follow(timeLeft(clock, now), now);
    const words = [
      stage.total > 1 ? say`${count(stage.done)} of ${count(stage.total)}` : '',
      say`${seconds(clock.ms + now - clock.markedAt)} so far`,
      left === null ? '' : remaining(left),
    ];
    return {
      ...(headline === name ? {} : { headline: name, live: name }),
      subline: words.filter(Boolean).join(' · '),
      share: clock.share,
      stages: stagesOf(clock, 'running'),
    };
  }
}
