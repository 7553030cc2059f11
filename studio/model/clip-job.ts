// A run over a clip of any length, window by window; finished frames are shown while the rest is computed. If the
// clip fits into one window, its session stays open for corrections.

import {
  CLIP_STAGES,
  ClipWork,
  StageClock,
  VideoSegmentation,
  countStep,
  fitSize,
  segmentVideo,
  untilAborted,
} from './library.js';
import { type ObjectFacts, Presence, type Result as ShownResult, type Segmentation } from './presence.js';
import { CLIP_MESSAGES, PageError, countObjects, headline, formatPlural, remark } from './messages.js';
import { Corrections } from './corrections.js';
import { Preview, needsPreview } from './preview.js';
import { runInSlices } from './slices.js';
import type { DecodedFrame, MaskEditor, Result, Session, SessionOptions as Options, StagePlan } from './library.js';
import type { VideoProgress, VideoResult, WindowResult } from './library.js';
import type { Source, Trim } from './source.js';
import type { Frames } from './store.js';

/** Frames of a window, and how many it shares with the next. */
export const { window: WINDOW, overlap: OVERLAP } = VideoSegmentation.defaults;

const NO_TRAJECTORIES = {
  count: 0,
  startFrame: new Uint32Array(0),
  offset: new Uint32Array(1),
  x: new Float32Array(0),
  y: new Float32Array(0),
  label: new Uint8Array(0),
};

/** The page's codes for errors of clips that are too short. */
const FEW_FRAMES = new Map([
  ['no-frames', 'no-frames'],
  ['too-few-frames', 'one-frame'],
]);

/** The result of a run so far, as the page shows it. */
export interface JobView {
  result: ShownResult;
  /** Positions of the objects, if counted already. */
  presence: Presence | null;
  /** Computes the scene without objects at a frame; null if not available. */
  background: ((frame: number) => Promise<Plate>) | null;
  numbers: string[];
  headline: (facts: ObjectFacts[]) => string;
  /** Returns the notice above the picture; empty for none. */
  notice: (facts: ObjectFacts[]) => string;
}

/** A region or stroke to paint. */
export type PaintRequest = Parameters<MaskEditor['paint']>[0];

/** The scene without objects, RGBA; the resolution may be lower than the clip's. */
export type Plate = { width: number; height: number; data: Uint8ClampedArray<ArrayBuffer> };

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

export class ClipJob extends StageClock {
  static stages: StagePlan[] = [...CLIP_STAGES];

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
  /** Corrections of the result. */
  corrections: Corrections;
  /** Message about corrections of the previous run that no longer apply. */
  droppedCorrections = '';
  /** Positions of the objects, as far as counted. */
  presence: Presence | null = null;

  inWindows: boolean;
  video: VideoSegmentation | null = null;
  /** The result of `video`; pending while the run is stopped. */
  completion: ReturnType<ClipJob['segment']> | undefined = undefined;
  abort = new AbortController();
  report = () => {};
  onWindow = () => {};
  stopped = false;
  /** True if the source has timestamps. */
  isTimed = true;
  /** True if some frames are finished and others are not. */
  isStreaming = false;
  windows = 0;
  /** Frames that the stages process. */
  work: ClipWork;
  /** Finished masks that `presence` has not counted yet. */
  pendingMasks: Iterator<unknown> = [].values();
  /** Masks of the whole clip, or of the finished frames if the run was stopped. */
  masks: VideoResult | null = null;
  /** Session of a clip that fits into one window. */
  session: Session | null = null;
  outputs: Result | undefined = undefined;
  /** Agreement of each frame's masks with nearby frames, 0 to 1, NaN if unknown; null in windows. */
  agreement: Float32Array | null = null;
  /** True if the masks contain corrections of an earlier visit. */
  hasEarlierCorrections = false;

  /** @param usualPace `pacePerPixel` of an earlier run; 0 if unknown */
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
    this.inWindows = trim.frames > WINDOW;
    this.work = new ClipWork(trim.frames, WINDOW, OVERLAP, source.direct !== undefined);
    this.countFrames();
    this.corrections = new Corrections(this);
  }

  /** Time of the run for each pixel and frame, in milliseconds; null if it does not predict other runs. */
  get pacePerPixel(): number | null {
    const { width, height, length } = this.images;
    return this.isPartial ? null : this.ms / (width * height * Math.max(1, length));
  }

  /** The corrections of the result on screen; null for a partial result. */
  get corrector() {
    return this.isPartial ? null : this.corrections;
  }

  /** True if the result has corrections. */
  get isCorrected() {
    return !this.isPartial && (this.hasEarlierCorrections || this.corrections.edits.length > 0);
  }

  /** The result with corrections of the session, without painted edits. */
  get result(): Result | VideoResult | null {
    return this.outputs ?? this.masks;
  }

  set result(result) {
    if (this.session) this.outputs = result as Result;
    else this.masks = result as VideoResult;
  }

  /** Windows repeat the stages. */
  get stageOnScreen() {
    return this.inWindows ? 'windows' : super.stageOnScreen;
  }

  /**
   * Runs to the end, from where it was stopped. Rejects with the signal's reason when aborted.
   * @param report called after each step
   * @param onWindow called when more frames are finished, except at the end
   */
  async run(signal: AbortSignal, report: () => void, onWindow: () => void) {
    Object.assign(this, { report, onWindow, stopped: false, masks: null });
    this.start();
    this.video?.resume();
    this.completion ??= this.segment();
    Object.assign(this, await untilAborted(this.completion, signal), { isStreaming: false });
  }

  async segment(): Promise<{ masks: VideoResult | null; outputs?: Result; agreement?: Float32Array | null }> {
    const { options, inWindows, abort } = this;
    const direct = this.source.direct?.(this.trim);
    const video = segmentVideo(direct?.source ?? this.frames(), {
      ...options,
      ...direct?.options,
      // A clip of one window is treated as one shot.
      ...(inWindows ? {} : { shot: { maxUnmatched: 1 } }),
      keep: true,
      frameRate: this.source.fps / this.trim.step,
      signal: abort.signal,
      onFrame: (frame) => this.read(frame),
      onProgress: (progress) => {
        this.advance(progress);
        if (!this.stopped) this.report();
      },
    });
    this.video = video;
    const masks = await video
      .collect((window) => this.addWindow(window))
      .catch((error) => {
        const code = FEW_FRAMES.get(error?.code);
        throw code ? new PageError(code) : error;
      });
    if (this.windows > 1 || abort.signal.aborted) video.session?.close();
    else this.session = video.session;
    const outputs = await this.session?.run();
    // Windows of a longer clip are gone by now.
    const agreement = outputs ? (await outputs.agreement()).frames : null;
    return { masks, agreement, ...(outputs ? { outputs } : {}) };
  }

  /** Yields the frames of sources that the package cannot read directly. */
  async *frames() {
    for await (const { frame, time, end = null } of this.source.frames(this.trim, this.abort.signal)) {
      this.isTimed = time !== null;
      if (time === null) yield frame;
      else yield end === null ? { frame, time } : { frame, time, duration: end - time };
    }
  }

  async read({ pixels, time, duration }: DecodedFrame) {
    const { trim, isTimed } = this;
    const end = isTimed && trim.step === 1 && duration > 0 ? time + duration : null;
    await this.addFrame((await pixels()) as ImageData, isTimed ? time : null, end);
  }

  /**
   * @param time in seconds
   * @param end of the frame in seconds, if known
   */
  async addFrame(frame: ImageData, time: number | null, end: number | null) {
    const { images, trim } = this;
    await this.receiveFrame(frame, time, end);
    this.mark('frames', images.length, Math.max(trim.frames, images.length));
    if (!this.stopped) this.report();
  }

  advance({ stage, done, total, window }: Pick<VideoProgress, 'stage' | 'done' | 'total' | 'window'>) {
    this.windows = Math.max(this.windows, window + 1);
    if (stage === 'decode') return;
    const { work, images } = this;
    // A clip may have fewer frames than its file says; only in windows it may also be a shot that ends.
    if (!this.inWindows) work.numFrames = images.length;
    countStep(this, work, { stage, done, total, window }, images.length);
  }

  /** Updates the frames that each stage has to process. */
  countFrames() {
    for (const stage of this.stages) stage.total = this.work.total(stage.id);
  }

  async addWindow(window: WindowResult) {
    // The first frame of the next window is read before a window is computed.
    const isLast = window.firstFrame + window.settled.to === this.images.length;
    this.isStreaming ||= !isLast;
    this.pendingMasks = this.addMasks(window);
    await runInSlices(this.pendingMasks);
    if (!isLast && !this.stopped) this.onWindow();
  }

  /** Counts one mask per step. */
  *addMasks(window: WindowResult) {
    this.presence ??= new Presence(window);
    if (window.shot > this.cuts.length) this.cuts.push(this.presence.frames.length);
    for (const { labels } of window.frames()) yield this.presence.addMask(labels);
  }

  /**
   * Stops the run and keeps the finished frames as the result. It can be continued.
   * @returns true if there are finished frames
   */
  stop(): boolean {
    this.video?.pause();
    while (!this.pendingMasks.next().done);
    this.stopped = true;
    this.masks = this.isStreaming ? (this.video?.collected ?? null) : null;
    return this.isPartial;
  }

  /** True if the run was stopped early and can continue. */
  get isPartial() {
    return this.stopped && this.masks !== null;
  }

  /** Number of finished frames while the run continues. */
  get settledFrames() {
    return this.isStreaming ? (this.presence?.frames.length ?? 0) : 0;
  }

  get shown(): JobView {
    const { outputs, presence, session, corrections } = this;
    const result = corrections.applyTo(outputs ? toMaskResult(outputs, this.agreement) : this.masksAsResult());
    if (!outputs || !session)
      return {
        ...{ result, presence, numbers: this.numbers, headline: countObjects, background: null },
        notice: (facts) => this.notice(facts),
      };
    return {
      ...{ result, presence },
      background: (t) => outputs.background(t),
      numbers: [`${formatPlural(this.images.length, 'frame')} of ${this.sizeText}`],
      headline: (facts) => headline(outputs, facts),
      notice: () => remark(outputs),
    };
  }

  get numbers() {
    return this.inWindows ? [this.extent, CLIP_MESSAGES.remark(WINDOW)] : [this.extent];
  }

  /** Returns `120 frames of 480 × 270 in 3 windows and 2 shots`. */
  get extent(): string {
    const shots = this.cuts.length + 1;
    const windows = formatPlural(this.windows, 'window');
    const parts = shots > 1 ? `${windows} and ${formatPlural(shots, 'shot')}` : windows;
    return `${formatPlural(this.masks?.numFrames ?? this.settledFrames, 'frame')} of ${this.sizeText} in ${parts}`;
  }

  notice(facts: ObjectFacts[]) {
    if (this.isPartial) return CLIP_MESSAGES.partial(this.settledFrames, this.trim.frames);
    const hasObjects = facts.some(({ object, first }) => object > 0 && first >= 0);
    return hasObjects || !this.masks ? '' : CLIP_MESSAGES.nothing;
  }

  /** Returns the masks in the form that layers draw; trajectories are empty until the run ends. */
  masksAsResult(): ShownResult {
    const { masks, video } = this;
    const { width, height } = masks ?? this.images;
    const trajectories = masks?.trajectories ?? NO_TRAJECTORIES;
    const highest = (this.presence?.frames ?? []).reduce((most, { n }) => Math.max(most, n.length - 1), 0);
    const objects = masks?.objects ?? Array.from({ length: highest }, (_, k) => ({ label: k + 1 }));
    return {
      ...{ width, height },
      numFrames: masks?.numFrames ?? this.settledFrames,
      trajectories,
      objects,
      labels: (t) => (masks ?? video)!.labels(t),
      toTracksDat: () => {
        if (!masks) throw new PageError('unfinished');
        return masks.toTracksDat();
      },
      doubts: masks?.doubts ?? [],
      agreement: this.agreement,
    };
  }

  /**
   * Updates the positions of objects after a correction.
   * @param frames the changed frames; null for all
   */
  recount(frames: number[] | null, segmentation: Segmentation) {
    this.presence = frames && segmentation.presence;
    const masks = this.corrections.masks;
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
    this.corrections.close();
    this.abort.abort();
    this.session?.close();
    this.preview?.close();
    this.images.close();
  }
}

function toMaskResult(outputs: Result, agreement: Float32Array | null): ShownResult {
  const { width, height, numFrames, trajectories, clusters } = outputs;
  const objectOf = clusters.object;
  const label = Uint8Array.from(clusters.label, (cluster) => objectOf[cluster]);
  return {
    ...{ width, height, numFrames, clusters, objects: outputs.objects },
    trajectories: { ...trajectories, label },
    labels: (t) => outputs.labels(t),
    toTracksDat: () => outputs.toTracksDat(),
    doubts: outputs.doubts,
    agreement,
  };
}
