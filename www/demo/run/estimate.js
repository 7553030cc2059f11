/** How much longer a run takes: from the usual shares of its stages, and from its pace so far. @module */

/** Part of the run, by usual shares, that must be through before anything is said. */
const LEAST_SHARE = 0.06;

/** Part of a stage from which its own pace says how long it takes. */
const OWN_PACE = 0.15;

/**
 * @param {import('./stage-clock.js').StageClock} clock
 * @param {number} now as `performance.now()`
 * @returns {number | null} milliseconds; null as long as it is anyone's guess
 */
export function timeLeft(clock, now) {
  const live = now - clock.markedAt;
  const { current } = clock;
  const stages = clock.stages.map((stage) => ({
    share: stage.share,
    part: stage.total > 0 ? stage.done / stage.total : 0,
    ms: stage.ms + (stage === current ? live : 0),
  }));
  const through = stages.reduce((sum, { share, part }) => sum + share * part, 0);
  const whole = stages.reduce((sum, { share }) => sum + share, 0);
  if (through < LEAST_SHARE * whole) return null;
  const pace = stages.reduce((sum, { ms, part }) => sum + (part > 0 ? ms : 0), 0) / through;
  return stages.reduce((sum, { share, part, ms }) => {
    if (part >= 1) return sum;
    if (part >= OWN_PACE) return sum + (ms * (1 - part)) / part;
    return sum + Math.max(0, share * pace - ms);
  }, 0);
}

/** Guesses jump; what is shown goes down with the clock and follows them slowly. */
export class Countdown {
  constructor() {
    /** @type {number | null} */
    this.left = null;
    this.at = 0;
  }

  /**
   * @param {number | null} guess milliseconds
   * @param {number} now
   * @returns {number | null} milliseconds to show
   */
  follow(guess, now) {
    if (guess === null) return null;
    const passed = now - this.at;
    this.at = now;
    if (this.left === null) this.left = guess;
    else
      this.left =
        Math.max(0, this.left - passed) + (guess - Math.max(0, this.left - passed)) * Math.min(1, passed / 1500);
    return this.left;
  }
}
