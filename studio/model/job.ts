// The base class of runs, and their types.

import { Preview, needsPreview } from './preview.js';
import { fitSize } from './library.js';
import { StageClock, type StagePlan } from './library.js';
import type { FrameDataSource } from './frame-data.js';
import type { ClipJob } from './clip-job.js';
import type { Corrections } from './corrections.js';
import type { MaskEditor, SessionOptions as Options } from './library.js';
import type { Segmentation, Result } from './segmentation.js';
import type { ObjectFacts, Presence } from './presence.js';
import type { Source, Trim } from './source.js';
import type { StillJob } from './still-job.js';
import type { Frames } from './store.js';

/** The result of a run so far, as the page shows it. */
export interface JobView {
  /** Null for a still image. */
  result: Result | null;
  /** Positions of the objects, if counted already. */
  presence: Presence | null;
  frameData: Partial<FrameDataSource>;
  numbers: string[];
  headline: (facts: ObjectFacts[]) => string;
  /** Returns the notice above the picture; empty for none. */
  notice: (facts: ObjectFacts[]) => string;
}

/** A region or stroke to paint. */
export type PaintRequest = Parameters<MaskEditor['paint']>[0];

/** A run of a clip or a still image, with `run`, `shown` and the static `stages`. */
export type AnyJob = ClipJob | StillJob;

/** The frames of a run for display. */
export type Images = Frames & {
  length: number;
  width: number;
  height: number;
  add: (frame: ImageData) => Promise<void>;
  open: (t: number) => Promise<CanvasImageSource | null>;
  pixels: (t: number, size: { width: number; height: number }) => Promise<ImageData>;
  close: () => void;
};

/** Number of runs of this page. */
let runs = 0;

export class Job extends StageClock {
  /** Identifies the run across pages. */
  id = `${Date.now()}-${(runs += 1)}`;
  images: Images;
  /** Times of the frames in seconds; empty if unknown. */
  times: number[] = [];
  /** Shown until the first masks are finished. */
  preview: Preview | null = null;
  /** End of the last frame in seconds. */
  end: number | null = null;
  /** First frames of further shots. */
  cuts: number[] = [];
  /** Corrections of the result; null if it cannot be corrected. */
  corrections: Corrections | null = null;
  /** Message about corrections of the previous run that no longer apply. */
  droppedCorrections = '';
  /** Positions of the objects, as far as counted. */
  presence: Presence | null = null;

  /** @param usualPace that of an earlier run, as `pacePerPixel`; 0 if not known */
  constructor(
    public source: Source,
    readonly trim: Trim,
    public options: Options,
    plan: StagePlan[],
    images: Images,
    usualPace = 0,
  ) {
    const { width, height } = fitSize(source, trim.side);
    const cost = plan.reduce((total, stage) => total + stage.cost, 0);
    super(plan, (usualPace * width * height) / cost);
    this.images = images;
  }

  /** Time of the run for each pixel and frame, in milliseconds; null if it does not predict other runs. */
  get pacePerPixel(): number | null {
    const { width, height, length } = this.images;
    return this.isPartial ? null : this.ms / (width * height * Math.max(1, length));
  }

  /** True if the run was stopped early and can continue. */
  get isPartial() {
    return false;
  }

  /** The corrections of the result on screen; null for a partial result. */
  get corrector() {
    return this.isPartial ? null : this.corrections;
  }

  /** True if the result has corrections. */
  get isCorrected() {
    return false;
  }

  /** Number of finished frames while the run continues. */
  get settledFrames() {
    return 0;
  }

  /**
   * Stops the run and keeps the finished frames as the result. It can be continued.
   * @returns true if there are finished frames
   */
  stop(): boolean {
    return false;
  }

  /**
   * Updates the positions of objects after a correction.
   * @param frames the changed frames; null for all
   */
  recount(frames: number[] | null, segmentation: Segmentation) {
    this.presence = frames && segmentation.presence;
    const masks = this.corrections?.masks;
    if (masks) frames?.forEach((t) => segmentation.presence.addMask(masks.labels(t), t));
  }

  /** Returns whether the run has these settings. */
  hasSettings(trim: Trim, options: Options): boolean {
    return JSON.stringify([trim, options]) === JSON.stringify([this.trim, this.options]);
  }

  /** The size of the frames: `480 × 270`. */
  get sizeText(): string {
    return `${this.images.width} × ${this.images.height}`;
  }

  /** Starts a preview if the run is long enough. */
  startPreview() {
    if (needsPreview(this.source, this.trim)) this.preview = new Preview(this.options);
  }

  /**
   * Stores a frame that was read.
   * @param end of the frame in seconds, if known
   */
  async receiveFrame(frame: ImageData, time: number | null, end: number | null) {
    // Copied first, as the bytes may be transferred to a worker.
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
