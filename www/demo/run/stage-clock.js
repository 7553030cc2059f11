/** Which stage a run is in, how far it is, and how long each has taken. @module */

/** @typedef {{id: string, name: string, share: number}} StagePlan A stage, and its usual share of the whole time. */

/** @typedef {StagePlan & {done: number, total: number, ms: number}} StageState */

export class StageClock {
  /** @param {StagePlan[]} plan in order */
  constructor(plan) {
    /** @type {StageState[]} */
    this.stages = plan.map((stage) => ({ ...stage, done: 0, total: 0, ms: 0 }));
    this.markedAt = 0;
  }

  /** From now on time counts. */
  start() {
    this.markedAt = performance.now();
  }

  /**
   * Books the time since the last step to this stage.
   *
   * @param {string} id
   * @param {number} done
   * @param {number} total
   */
  mark(id, done, total) {
    const now = performance.now();
    let stage = this.stages.find((s) => s.id === id);
    if (!stage) {
      stage = { id, name: id[0].toUpperCase() + id.slice(1), share: 0.05, done: 0, total: 0, ms: 0 };
      this.stages.push(stage);
    }
    stage.ms += now - this.markedAt;
    stage.done = done;
    stage.total = total;
    this.markedAt = now;
  }

  /** @returns {StageState | undefined} the stage under way: the first that is not through */
  get current() {
    return this.stages.find((stage) => stage.total === 0 || stage.done < stage.total);
  }

  /** @returns {number} in 0..1 */
  get share() {
    const whole = this.stages.reduce((sum, stage) => sum + stage.share, 0);
    const sum = this.stages.reduce((s, { share, done, total }) => s + (total > 0 ? (share * done) / total : 0), 0);
    return sum / whole;
  }

  /**
   * @returns {StagePlan[] | null} the stages with the shares that they took this time, for the estimate of the next;
   *   null where these would say nothing
   */
  get measured() {
    const whole = Math.max(1, this.ms);
    return this.stages.map(({ id, name, ms }) => ({ id, name, share: Math.max(0.005, ms / whole) }));
  }

  /** @returns {number} milliseconds of all stages */
  get ms() {
    return this.stages.reduce((sum, stage) => sum + stage.ms, 0);
  }
}

/**
 * @template T
 * @param {Promise<T>} promise
 * @param {AbortSignal} signal
 * @returns {Promise<T>} settles with the promise, or rejects with the signal's reason if that comes first
 */
export function untilAborted(promise, signal) {
  return new Promise((resolve, reject) => {
    if (signal.aborted) return reject(signal.reason);
    signal.addEventListener('abort', () => reject(signal.reason), { once: true });
    promise.then(resolve, reject);
  });
}
