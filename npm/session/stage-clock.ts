// Stages of a run: the finished share and the time left, from the pieces done.

/**
 * A stage of a run. `cost` is the usual time of one piece, in any unit that all stages of a plan share; `total` the number
 * of pieces as far as known.
 */
export type StagePlan = {
  id: string;
  cost: number;
  total?: number;
  /** True for a stage whose pace says little about the others: reading depends on the file. */
  isReading?: boolean;
};

type Stage = Required<StagePlan> & {
  done: number;
  /** Recent pieces and their time in milliseconds: older ones count less. */
  recentDone: number;
  recentMs: number;
};

/** Time over which pieces lose weight, as a share of the time so far: the machine may have become busier. */
const MEMORY_SHARE = 0.15;

/** Pieces of a stage after which its own pace counts as much as the pace of all stages. */
const OWN_PACE_PIECES = 20;

/** Share of the work after which the pace of this run counts as much as that of an earlier one. */
const USUAL_PACE_SHARE = 0.02;

/** Smallest part of a run with an estimate of the time left, and its shortest time in milliseconds. */
const MIN_SHARE = 0.08;
const MIN_ELAPSED_MS = 2000;

/** Time in which the shown time left follows the estimate, in milliseconds. */
const SMOOTHING_MS = 1000;

// The constants above fit the recorded runs of tests/node/studio-progress.test.mjs.

export class StageClock {
  stages: Stage[];
  /** The finished share of the run, 0 to 1. It never falls. */
  share = 0;
  /** Time of all pieces, in milliseconds. */
  ms = 0;
  markedAt = 0;
  /** The time left as last shown. */
  shownLeft: { ms: number; at: number } | null = null;

  /**
   * @param plan in order
   * @param usualPace milliseconds per unit of cost in an earlier run; 0 if not known
   */
  constructor(
    plan: readonly StagePlan[],
    readonly usualPace = 0,
  ) {
    this.stages = plan.map((stage) => ({
      ...{ total: 1, isReading: false, ...stage },
      ...{ done: 0, recentDone: 0, recentMs: 0 },
    }));
  }

  /** The first stage that is not finished; the last one if all are. */
  get current(): Stage {
    return this.stages.find(({ done, total }) => done < total) ?? this.stages[this.stages.length - 1]!;
  }

  /** Id of the stage to name on screen. */
  get stageOnScreen(): string {
    return this.current.id;
  }

  start() {
    this.markedAt = performance.now();
  }

  /** Adds the time since the last call to a stage, and the pieces done. */
  mark(id: string, done: number, total?: number) {
    const now = performance.now();
    const ms = now - this.markedAt;
    this.markedAt = now;
    const kept = this.ms > 0 ? Math.exp(-ms / (MEMORY_SHARE * this.ms)) : 1;
    for (const stage of this.stages) {
      stage.recentDone *= kept;
      stage.recentMs *= kept;
    }
    this.ms += ms;
    this.stage(id).recentMs += ms;
    this.count(id, done, total);
  }

  /** Counts pieces that took no time. The share grows by their part of what was left. */
  count(id: string, done: number, total?: number) {
    const stage = this.stage(id);
    const added = Math.max(0, done - stage.done);
    // A stage that turns out longer has done a smaller part.
    if (done < stage.done) stage.recentDone *= done / stage.done;
    stage.recentDone += added;
    stage.done = done;
    if (total !== undefined) stage.total = total;
    const addedMs = added * this.paceOf(stage);
    const { msLeft } = this;
    if (msLeft <= 0) this.share = 1;
    else this.share += ((1 - this.share) * addedMs) / (msLeft + addedMs);
  }

  has(id: string) {
    return this.stages.some((stage) => stage.id === id);
  }

  stage(id: string): Stage {
    return this.stages.find((stage) => stage.id === id)!;
  }

  /** Returns the milliseconds per unit of cost in these stages; 0 if not known. */
  paceIn(stages: Stage[]): number {
    const weight = USUAL_PACE_SHARE * sum(this.stages, ({ cost, total }) => cost * total);
    const usual = this.usualPace > 0 ? weight : 0;
    const cost = usual + sum(stages, (stage) => stage.cost * stage.recentDone);
    return cost > 0 ? (usual * this.usualPace + sum(stages, ({ recentMs }) => recentMs)) / cost : 0;
  }

  /** The pace of the stages that predict others; 0 if not known. */
  get pace() {
    return this.paceIn(this.stages.filter(({ isReading }) => !isReading));
  }

  /** Returns the milliseconds that a piece takes. */
  paceOf({ cost, recentDone, recentMs }: Stage): number {
    const expected = cost * (this.pace || this.paceIn(this.stages));
    return (recentMs + OWN_PACE_PIECES * expected) / (recentDone + OWN_PACE_PIECES);
  }

  /** Estimated time of the pieces that are left, in milliseconds. */
  get msLeft(): number {
    return sum(this.stages, (stage) => Math.max(0, stage.total - stage.done) * this.paceOf(stage));
  }

  /**
   * Returns the time left in milliseconds, smoothed for display; null if too early.
   * @param now as `performance.now()`
   */
  timeLeft(now: number): number | null {
    if (!this.pace) return null;
    const live = now - this.markedAt;
    // The piece that is being done is not all of what is left.
    const left = Math.max(this.msLeft - live, this.msLeft / 2);
    const passed = this.shownLeft ? now - this.shownLeft.at : Infinity;
    const expected = this.shownLeft ? Math.max(0, this.shownLeft.ms - passed) : left;
    const ms = expected + (left - expected) * Math.min(1, passed / SMOOTHING_MS);
    this.shownLeft = { ms, at: now };
    const elapsed = this.ms + live;
    return elapsed < MIN_ELAPSED_MS || elapsed < MIN_SHARE * (elapsed + ms) ? null : ms;
  }
}

function sum<T>(items: T[], valueOf: (item: T) => number): number {
  return items.reduce((total, item) => total + valueOf(item), 0);
}
