// Which stage a run is in, how far it is, how long each has taken, how much longer all take; and work in slices.

/** A stage, and its usual share of the whole time. */
export type StagePlan = { id: string; share: number };

type StageState = StagePlan & { done: number; total: number; ms: number };

export class StageClock {
  stages: StageState[];
  markedAt = 0;

  /** @param plan in order */
  constructor(plan: StagePlan[]) {
    this.stages = plan.map((stage) => ({ ...stage, done: 0, total: 0, ms: 0 }));
  }

  /** From now on time counts. */
  start() {
    this.markedAt = performance.now();
  }

  /** Books the time since the last step to this stage. */
  mark(id: string, done: number, total: number) {
    const now = performance.now();
    let stage = this.stages.find((s) => s.id === id);
    if (!stage) {
      stage = { id, share: 0.05, done: 0, total: 0, ms: 0 };
      this.stages.push(stage);
    }
    stage.ms += now - this.markedAt;
    stage.done = done;
    stage.total = total;
    this.markedAt = now;
  }

  /** Returns the stage under way: the first that is not through. */
  get current(): StageState | undefined {
    return this.stages.find((stage) => stage.total === 0 || stage.done < stage.total);
  }

  /** Returns the share that is done, 0 to 1. */
  get share(): number {
    const whole = this.stages.reduce((sum, stage) => sum + stage.share, 0);
    const sum = this.stages.reduce((s, { share, done, total }) => s + (total > 0 ? (share * done) / total : 0), 0);
    return sum / whole;
  }

  /**
   * @returns the stages with the shares that they took this time, for the estimate of the next; null where these
   *   would say nothing
   */
  get measured(): StagePlan[] | null {
    const whole = Math.max(1, this.ms);
    return this.stages.map(({ id, ms }) => ({ id, share: Math.max(0.005, ms / whole) }));
  }

  /** Returns milliseconds of all stages. */
  get ms(): number {
    return this.stages.reduce((sum, stage) => sum + stage.ms, 0);
  }
}

/** Settles with the promise, or rejects with the signal's reason if that comes first. */
export function untilAborted<T>(promise: Promise<T>, signal: AbortSignal): Promise<T> {
  return new Promise((resolve, reject) => {
    if (signal.aborted) return reject(signal.reason);
    signal.addEventListener('abort', () => reject(signal.reason), { once: true });
    promise.then(resolve, reject);
  });
}

/** Part of the run, by usual shares, that must be through before anything is said. */
const LEAST_SHARE = 0.06;

/** Part of a stage from which its own pace says how long it takes. */
const OWN_PACE = 0.15;

/**
 * @param now as `performance.now()`
 * @returns milliseconds; null as long as it is anyone's guess
 */
export function timeLeft(clock: StageClock, now: number): number | null {
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
  left: number | null = null;
  at = 0;

  /**
   * @param guess milliseconds
   * @returns milliseconds to show
   */
  follow(guess: number | null, now: number): number | null {
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

/** How long a slice may last, in milliseconds, before others get their turn. */
const SLICE_MS = 12;

/** Resolves when others have had their turn. */
export function turn() {
  return new Promise((done: (value: void) => void) => setTimeout(done));
}

/** Goes on with the work to its end, step by step. */
export async function inSlices(work: Iterator<unknown>) {
  let until = performance.now() + SLICE_MS;
  while (!work.next().done) {
    if (performance.now() < until) continue;
    await turn();
    until = performance.now() + SLICE_MS;
  }
}
