// The frames that each stage of a clip's run has to process, window by window.

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
