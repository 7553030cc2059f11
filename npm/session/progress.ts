// Progress of a clip's run: the stages' pieces done, the frames that each stage has to process, window by window, and the
// finished share and the time left that follow.

import { STAGE_COSTS } from '../parameters.js';
import type { Stage, StageStep } from './engine.js';

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

type TimedStage = Required<StagePlan> & {
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

// The constants above fit the recorded runs of tests/studio/windows.test.mjs.

export class StageClock {
  stages: TimedStage[];
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
  get current(): TimedStage {
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

  stage(id: string): TimedStage {
    return this.stages.find((stage) => stage.id === id)!;
  }

  /** Returns the milliseconds per unit of cost in these stages; 0 if not known. */
  paceIn(stages: TimedStage[]): number {
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
  paceOf({ cost, recentDone, recentMs }: TimedStage): number {
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

/** Stages of a clip, with their usual times for a frame as measured. */
export const CLIP_STAGES: readonly StagePlan[] = [
  { id: 'frames', cost: 0.35, isReading: true },
  ...STAGE_COSTS.map(([id, cost]) => ({ id, cost })),
];

/** Stages that only a run with masks has, and only one with frames. */
export const STAGES_OF_MASKS = ['superpixels', 'cut', 'masks'];
export const STAGES_OF_FRAMES = ['flow', 'trajectories', 'saliency', 'connectedness', ...STAGES_OF_MASKS];

/** Stages that have ended when another one begins, though they may not have reported their last step. */
const ENDED_BEFORE: Partial<Record<Stage, Stage[]>> = { affinities: ['flow', 'trajectories'], masks: ['cut'] };

/** Numbers of frames: the new ones of a window, and all of them, with those that it shares with the one before. */
type FrameCounts = { fresh: number; all: number };

/** Stages that process only the new frames of a window. */
const FRESH_STAGES = new Set(['frames', 'flow', 'trajectories']);

/**
 * Expected steps of a cut for each frame, and if other clusterings are tried, as measured: the engine knows only of the
 * present round.
 */
const CUT_STEPS = { usual: 2.8, mostUsual: 4, withOthers: 8.5 };

export class ClipWork {
  /** Frames of the finished windows. */
  finished: FrameCounts = { fresh: 0, all: 0 };
  present: FrameCounts;
  /** Number of the present window. */
  window = 0;

  /**
   * @param size frames of a window
   * @param overlap frames shared by neighbouring windows
   * @param fillsLast true if the last window shares so many frames that it is full
   */
  constructor(
    public numFrames: number,
    readonly size: number,
    readonly overlap: number,
    readonly fillsLast: boolean,
  ) {
    this.present = { fresh: Math.min(size, numFrames), all: Math.min(size, numFrames) };
  }

  /** Begins a window. @param read frames read so far */
  begin(window: number, read: number) {
    if (window > this.window) {
      this.finished = add(this.finished, this.present);
      this.present = this.windowAfter(this.finished.fresh);
      this.window = window;
    }
    // A shot that ends early ends its window.
    const unread = Math.max(0, this.finished.fresh + this.present.fresh - read);
    this.present = { fresh: this.present.fresh - unread, all: this.present.all - unread };
  }

  windowAfter(done: number): FrameCounts {
    const fresh = Math.max(1, Math.min(this.size - this.overlap, this.numFrames - done));
    return { fresh, all: this.fillsLast ? this.size : fresh + this.overlap };
  }

  /** Returns how many frames a stage has to process in the whole clip, as expected. */
  total(stage: string): number {
    let total = add(this.finished, this.present);
    while (total.fresh < this.numFrames) total = add(total, this.windowAfter(total.fresh));
    return total[kindOf(stage)];
  }

  /** Returns how many frames a stage has processed at the end of the present window. */
  doneInWindows(stage: string): number {
    const kind = kindOf(stage);
    return this.finished[kind] + this.present[kind];
  }

  /** Returns how many frames a stage has processed after some steps of the present window. */
  done(stage: string, steps: number, totalSteps: number): number {
    const { finished, present } = this;
    const kind = kindOf(stage);
    // Steps of shared frames are counted, but done.
    const stepsBefore = totalSteps * (1 - present[kind] / present.all);
    const isInCut = stage === 'cut' && steps < totalSteps;
    const expected = isInCut ? present.all * cutSteps(totalSteps / present.all) : 0;
    const part = (steps - stepsBefore) / Math.max(1, totalSteps - stepsBefore, expected);
    return finished[kind] + present[kind] * Math.max(0, part);
  }
}

function kindOf(stage: string): keyof FrameCounts {
  return FRESH_STAGES.has(stage) ? 'fresh' : 'all';
}

function cutSteps(told: number): number {
  return told > CUT_STEPS.mostUsual ? CUT_STEPS.withOthers : CUT_STEPS.usual;
}

function add(a: FrameCounts, b: FrameCounts): FrameCounts {
  return { fresh: a.fresh + b.fresh, all: a.all + b.all };
}

/** A step of a stage, in a window of a clip. */
export type WindowStep = StageStep & { window: number };

/** Counts a step. @param numRead frames read so far */
export function countStep(clock: StageClock, work: ClipWork, step: WindowStep, numRead: number) {
  work.begin(step.window, numRead);
  for (const stage of clock.stages) stage.total = work.total(stage.id);
  for (const ended of ENDED_BEFORE[step.stage] ?? [])
    if (clock.has(ended)) clock.count(ended, work.doneInWindows(ended));
  // A run without tracking or masks may report stages that cost nothing.
  if (clock.has(step.stage)) clock.mark(step.stage, work.done(step.stage, step.done, step.total));
}

/** The finished share of a run and the time left. */
export type RunEstimate = {
  /** Finished share of the run, 0 to 1, as estimated from the usual times of the stages; it never falls. */
  readonly share: number;
  /** Estimated time left in seconds; null in the first two seconds and the first twelfth of a run. */
  readonly secondsLeft: number | null;
};

/**
 * Progress of a run: `done` of `total` steps of a stage; steps differ in duration. `done` only grows; so does `total` during
 * the cut, and is constant elsewhere.
 */
export type Progress = StageStep & RunEstimate;

/** Estimates the progress of a run from its steps. */
export class RunMeter {
  #clock: StageClock | undefined;
  #stages;
  #work: ClipWork;

  /** @param without stages that the run does not have */
  constructor(work: ClipWork, without: readonly string[] = []) {
    this.#work = work;
    this.#stages = CLIP_STAGES.filter(({ id }) => !without.includes(id));
  }

  /** The next step begins now: time before it does not count. */
  resume() {
    this.#clock?.start();
  }

  /** @param numFrames of the clip, as far as known */
  countRead(numRead: number, numFrames: number): RunEstimate {
    const clock = this.#start('frames');
    this.#work.numFrames = numFrames;
    for (const stage of clock.stages) stage.total = this.#work.total(stage.id);
    clock.mark('frames', numRead, numFrames);
    return this.#estimate(clock);
  }

  countStep(step: WindowStep, numRead: number, numFrames: number): RunEstimate {
    const clock = this.#start(step.stage);
    this.#work.numFrames = numFrames;
    countStep(clock, this.#work, step, numRead);
    if (clock.has('frames')) clock.count('frames', numRead, numFrames);
    return this.#estimate(clock);
  }

  /** Starts the clock. A run that continues has only the stages from its first step on; flow and tracking run together. */
  #start(stage: string) {
    if (this.#clock) return this.#clock;
    const first = stage === 'trajectories' ? 'flow' : stage;
    const index = this.#stages.findIndex(({ id }) => id === first);
    this.#clock = new StageClock(this.#stages.slice(Math.max(0, index)));
    this.#clock.start();
    return this.#clock;
  }

  #estimate(clock: StageClock): RunEstimate {
    const msLeft = clock.share === 1 ? 0 : clock.timeLeft(performance.now());
    return { share: clock.share, secondsLeft: msLeft === null ? null : msLeft / 1000 };
  }
}
