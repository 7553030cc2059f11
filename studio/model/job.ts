// What all kinds of runs have in common, and what the page may ask of them.

import { Preview, isWorth } from './preview.js';
import { StageClock, type StagePlan } from './stage-clock.js';
import type { Answers } from './answers.js';
import type { ClipJob } from './clip-job.js';
import type { Corrections } from './corrections.js';
import type { Edit, MaskEditor, SessionOptions as Options } from './library.js';
import type { Points, Result } from './points.js';
import type { Facts, Presence } from './presence.js';
import type { Source, Take } from './source.js';
import type { StillJob } from './still-job.js';
import type { Frames } from './store.js';

/** What a run has found so far, as the page shows it. */
export interface Shown {
  /** Null for a still image. */
  result: Result | null;
  /** Where each object is, if that is known already. */
  presence: Presence | null;
  answers: Partial<Answers>;
  /** For the line of facts. */
  numbers: string[];
  headline: (facts: Facts[]) => string;
  /** What else there is to say, empty for nothing. */
  notice: (facts: Facts[]) => string;
}

/** What is to be painted, where. */
export type ToPaint = Parameters<MaskEditor['paint']>[0];

/** Something painted, and the frames that have it. */
export type Painted = { edit: Edit; frames: number[] };

/** Runs of clips and of still images, each with `run`, `shown` and the static `stagesFor`. */
export type AnyJob = ClipJob | StillJob;

/** The frames of a run as they are shown. */
export type Images = Frames & {
  length: number;
  width: number;
  height: number;
  add: (frame: ImageData) => Promise<void>;
  open: (t: number) => Promise<CanvasImageSource | null>;
  pixels: (t: number, size: { width: number; height: number }) => Promise<ImageData>;
  close: () => void;
};

/** Runs of this page. */
let runs = 0;

export class Job extends StageClock {
  /** Which run the result is of, in this page and others. */
  id = `${Date.now()}-${(runs += 1)}`;
  images: Images;
  /** When they are shown, in seconds; none where nobody knows. */
  times: number[] = [];
  /** What is shown until the first masks are there. */
  preview: Preview | null = null;
  /** When the last of them ends. */
  end: number | null = null;
  /** First frames of further shots. */
  cuts: number[] = [];
  /** Of the result, where it can be corrected. */
  corrections: Corrections | null = null;
  /** What of the corrections of the run before no longer applies, in words. */
  lost = '';
  /** Where objects are, as far as that is counted. */
  presence: Presence | null = null;

  constructor(
    public source: Source,
    readonly take: Take,
    public options: Options,
    plan: StagePlan[],
    images: Images,
  ) {
    super(plan);
    this.images = images;
  }

  /** Whether the result comes from a run which was stopped early, and can go on. */
  get partial() {
    return false;
  }

  /** What corrects the result on screen; a part of a clip stays as it is. */
  get corrector() {
    return this.partial ? null : this.corrections;
  }

  /** Whether there is something in the result that another run would not have. */
  get isCorrected() {
    return false;
  }

  /** Frames that are settled while others are still to come. */
  get settled() {
    return 0;
  }

  /**
   * After a cancel: keeps what is settled as the result, where that is one.
   * @returns whether it is; either way the run may be run again, and goes on where it was
   */
  stop(): boolean {
    return false;
  }

  /**
   * After a correction: where each object is now.
   * @param frames those that changed; null for all
   */
  recount(frames: number[] | null, points: Points) {
    this.presence = frames && points.presence;
    const masks = this.corrections?.masks;
    if (masks) frames?.forEach((t) => points.presence.addMask(masks.labels(t), t));
  }

  /** Returns whether this is a run with these settings. */
  isFor(take: Take, options: Options): boolean {
    return JSON.stringify([take, options]) === JSON.stringify([this.take, this.options]);
  }

  /** Returns the size of its frames: `480 × 270`. */
  get size(): string {
    return `${this.images.width} × ${this.images.height}`;
  }

  /** Begins a preview, if the masks take so long that it is worth one. */
  look() {
    if (isWorth(this.source, this.take)) this.preview = new Preview(this.options);
  }

  /**
   * A frame has been read.
   * @param end when it is over, where that is known
   */
  async arrived(frame: ImageData, time: number | null, end: number | null) {
    // The picture is copied before others get the bytes, who may hand them on to a worker.
    await this.images.add(frame);
    if (time !== null) this.times.push(time);
    this.end = end;
    this.preview?.add(frame);
  }

  close() {
    this.preview?.close();
    this.images.close();
  }
}
