/** What is shown while a run is under way: stage, share, time so far and time left. @module */

import { byId } from './dom.js';
import { Countdown, timeLeft } from './estimate.js';
import { showStages } from './panel-stages.js';
import { say, showProgress, showSubline } from './status.js';
import { count, remaining, seconds } from './words.js';

/** @typedef {import('./stage-clock.js').StageClock} StageClock */

/** One run's progress. */
export class Progress {
  constructor() {
    this.countdown = new Countdown();
  }

  /** @param {StageClock} clock */
  show(clock) {
    const stage = clock.current;
    if (!stage) return;
    if (byId('headline').textContent !== stage.name) {
      byId('headline').textContent = stage.name;
      say(stage.name);
    }
    const now = performance.now();
    const left = this.countdown.follow(timeLeft(clock, now), now);
    const words = [
      stage.total > 1 ? `${count(stage.done)} of ${count(stage.total)}` : '',
      `${seconds(clock.ms + now - clock.markedAt)} so far`,
      left === null ? '' : remaining(left),
    ];
    showSubline(words.filter(Boolean).join(' · '));
    showProgress(clock.share);
    showStages(clock, 'running');
  }
}
