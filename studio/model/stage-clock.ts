// Stages of a run: progress, times and the estimated time left; and work in slices.

/** A stage and its usual share of the time. */
export type StagePlan = { id: string; share: number };

type StageState = StagePlan & { done: number; total: number; ms: number };

export class StageClock {
  stages: StageState[];
  markedAt = 0;

  /** @param plan in order */
  constructor(plan: StagePlan[]) {
    this.stages = plan.map((stage) => ({ ...stage, done: 0, total: 0, ms: 0 }));
  }

  start() {
    this.markedAt = performance.now();
  }

  /** Adds the time since the last call to a stage. */
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

  /** The current stage: the first that is not finished. */
  get current(): StageState | undefined {
    return this.stages.find((stage) => stage.total === 0 || stage.done < stage.total);
  }

  /** The finished share of the run, 0 to 1. */
  get share(): number {
    const total = this.stages.reduce((sum, stage) => sum + stage.share, 0);
    const sum = this.stages.reduce((s, { share, done, total }) => s + (total > 0 ? (share * done) / total : 0), 0);
    return sum / total;
  }

  /** The stages with measured shares, for the next estimate; null if they do not predict it. */
  get measured(): StagePlan[] | null {
    const totalMs = Math.max(1, this.ms);
    return this.stages.map(({ id, ms }) => ({ id, share: Math.max(0.005, ms / totalMs) }));
  }

  /** Time of all stages, in milliseconds. */
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

/** Smallest finished share with an estimate; chosen by eye. */
const MIN_DONE_SHARE = 0.06;

/** Smallest finished share of a stage whose own pace is used; chosen by eye. */
const MIN_STAGE_SHARE = 0.15;

/**
 * @param now as `performance.now()` Estimates the time left.
 * @returns milliseconds; null if too early
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
  const total = stages.reduce((sum, { share }) => sum + share, 0);
  if (through < MIN_DONE_SHARE * total) return null;
  const pace = stages.reduce((sum, { ms, part }) => sum + (part > 0 ? ms : 0), 0) / through;
  return stages.reduce((sum, { share, part, ms }) => {
    if (part >= 1) return sum;
    if (part >= MIN_STAGE_SHARE) return sum + (ms * (1 - part)) / part;
    return sum + Math.max(0, share * pace - ms);
  }, 0);
}

/** Smooths estimates of the time left, which jump. */
export class Countdown {
  left: number | null = null;
  at = 0;

  /**
   * @param guess milliseconds
   * @returns milliseconds to show
   */
  follow(guess: number | null, now: number): number | null {
    if (guess === null) return null;
    const elapsed = now - this.at;
    this.at = now;
    if (this.left === null) this.left = guess;
    else
      this.left =
        Math.max(0, this.left - elapsed) + (guess - Math.max(0, this.left - elapsed)) * Math.min(1, elapsed / 1500);
    return this.left;
  }
}

/** Longest slice of work in milliseconds: less than a frame at 60 Hz. */
const SLICE_MS = 12;

/** Resolves after other tasks of the page. */
export function yieldToPage() {
  return new Promise((resolve: (value: void) => void) => setTimeout(resolve));
}

/** Runs work to its end in slices. */
export async function runInSlices(work: Iterator<unknown>) {
  let until = performance.now() + SLICE_MS;
  while (!work.next().done) {
    if (performance.now() < until) continue;
    await yieldToPage();
    until = performance.now() + SLICE_MS;
  }
}
