// Progress of a clip's run: the frames that each stage has to process, window by window, and what they say about the
// finished share and the time left.

import { STAGE_COSTS } from '../parameters.js';
import { StageClock, type StagePlan } from './stage-clock.js';
import type { Stage, StageStep } from './engine.js';

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
