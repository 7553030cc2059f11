// A run over a clip of any length, window by window: what is settled is shown while more is to come. Of a clip that is
// one window the session stays open: it corrects. Work that is opened again is such a run
// whose masks are there already.

import { VideoSegmentation, segmentVideo } from './library.js';
import { type Facts, Presence } from './presence.js';
import { LONG, PageError, countObjects, headline, plural, remark } from './words.js';
import { Corrections } from './corrections.js';
import { Job, type Shown } from './job.js';
import { type StagePlan, inSlices, untilAborted } from './stage-clock.js';
import type { DecodedFrame, Result, Session, VideoResult, WindowResult } from './library.js';
import type { Result as ShownResult } from './points.js';
import type { Take } from './source.js';

/** Frames that are segmented together, and how many of them the next window shares. */
export const { window: WINDOW, overlap: OVERLAP } = VideoSegmentation.defaults;

/**
 * Stages of a clip that is one window, with the share of the whole time that each usually takes; after a run, its own
 * shares are taken.
 */
const STAGES: StagePlan[] = [
  { id: 'frames', share: 0.14 },
  { id: 'flow', share: 0.33 },
  { id: 'trajectories', share: 0.12 },
  { id: 'affinities', share: 0.02 },
  { id: 'embedding', share: 0.04 },
  { id: 'discontinuities', share: 0.02 },
  { id: 'saliency', share: 0.06 },
  { id: 'connectedness', share: 0.03 },
  { id: 'clusters', share: 0.03 },
  { id: 'superpixels', share: 0.16 },
  { id: 'cut', share: 0.05 },
  { id: 'masks', share: 0.07 },
];

/** Those of a longer one. */
const WINDOW_STAGES: StagePlan[] = [
  { id: 'windows', share: 0.9 },
  { id: 'frames', share: 0.1 },
];

const NO_TRAJECTORIES = {
  count: 0,
  startFrame: new Uint32Array(0),
  offset: new Uint32Array(1),
  x: new Float32Array(0),
  y: new Float32Array(0),
  label: new Uint8Array(0),
};

/** Errors of clips that are too short, as the page calls them. */
const FEW_FRAMES = new Map([
  ['no-frames', 'no-frames'],
  ['too-few-frames', 'one-frame'],
]);

export class ClipJob extends Job {
  static stagesFor({ frames }: Take) {
    return frames > WINDOW ? WINDOW_STAGES : STAGES;
  }

  inWindows: boolean;
  declare corrections: Corrections;
  video: VideoSegmentation | null = null;
  /** The work that `video` does; it waits while the run is stopped. */
  working: ReturnType<ClipJob['work']> | undefined = undefined;
  life = new AbortController();
  report = () => {};
  onWindow = () => {};
  stopped = false;
  /** Whether the source says when its frames are shown. */
  isTimed = true;
  /** Whether something was settled while more was to come, and the run is not through. */
  streaming = false;
  windows = 0;
  /** What the package has settled, on its way to `presence`. */
  settling: Iterator<unknown> = [].values();
  /** Of the whole clip, or of what was settled when the run was stopped. */
  masks: VideoResult | null = null;
  /** Of a clip that is one window. */
  session: Session | null = null;
  found: Result | undefined = undefined;
  /** Whether corrections of an earlier visit are in the masks themselves. */
  holdsOthers = false;

  constructor(...parts: ConstructorParameters<typeof Job>) {
    super(...parts);
    this.inWindows = this.take.frames > WINDOW;
    this.corrections = new Corrections(this);
  }

  get isCorrected() {
    return !this.partial && (this.holdsOthers || this.corrections.edits.length > 0);
  }

  /** Returns the result as corrected, without what was done by hand. */
  get result(): Result | VideoResult | null {
    return this.found ?? this.masks;
  }

  set result(result) {
    if (this.session) this.found = result as Result;
    else this.masks = result as VideoResult;
  }

  /** The stages of windows go on side by side: their times say nothing about the next run. */
  get measured() {
    return this.inWindows ? null : super.measured;
  }

  /**
   * Runs to the end, from where it was stopped. Rejects with the signal's reason as soon as it is aborted.
   * @param report called after each step
   * @param onWindow called when more frames are settled, and others are still to come
   */
  async run(signal: AbortSignal, report: () => void, onWindow: () => void) {
    Object.assign(this, { report, onWindow, stopped: false, masks: null });
    this.start();
    this.video?.resume();
    this.working ??= this.work();
    Object.assign(this, await untilAborted(this.working, signal), { streaming: false });
  }

  async work(): Promise<{ masks: VideoResult | null; found?: Result }> {
    const { options, inWindows, life } = this;
    const direct = this.source.direct?.(this.take);
    const video = segmentVideo(direct?.source ?? this.frames(), {
      ...options,
      ...direct?.options,
      // What fits into one window is one shot.
      ...(inWindows ? {} : { shot: { maxUnmatched: 1 } }),
      keep: true,
      frameRate: this.source.fps / this.take.step,
      signal: life.signal,
      onFrame: (frame) => this.read(frame),
      onProgress: (progress) => {
        this.advance(progress);
        if (!this.stopped) this.report();
      },
    });
    this.video = video;
    const masks = await video
      .collect((window) => this.add(window))
      .catch((error) => {
        const code = FEW_FRAMES.get(error?.code);
        throw code ? new PageError(code) : error;
      });
    this.endReading();
    if (inWindows) this.mark('windows', 1, 1);
    if (this.windows > 1 || life.signal.aborted) video.session?.close();
    else this.session = video.session;
    return { masks, found: await this.session?.run() };
  }

  /** Of a source that the package does not read by itself. */
  async *frames() {
    for await (const { frame, time, end = null } of this.source.frames(this.take, this.life.signal)) {
      this.isTimed = time !== null;
      if (time === null) yield frame;
      else yield end === null ? { frame, time } : { frame, time, duration: end - time };
    }
  }

  async read({ pixels, time, duration }: DecodedFrame) {
    const { take, isTimed } = this;
    const end = isTimed && take.step === 1 && duration > 0 ? time + duration : null;
    await this.show((await pixels()) as ImageData, isTimed ? time : null, end);
  }

  /**
   * @param time in seconds
   * @param end when it is over, in seconds, where that is known
   */
  async show(frame: ImageData, time: number | null, end: number | null) {
    const { images, take } = this;
    await this.arrived(frame, time, end);
    this.mark('frames', images.length, Math.max(take.frames, images.length + 1));
    if (!this.stopped) this.report();
  }

  endReading() {
    const stage = this.stages.find(({ id }) => id === 'frames');
    if (stage) stage.total = stage.done;
  }

  advance({ stage, done, total, window }: { stage: string; done: number; total: number; window: number }) {
    this.windows = Math.max(this.windows, window + 1);
    const at = STAGES.findIndex(({ id }) => id === stage);
    if (!this.inWindows) {
      if (at < 0) return;
      this.endReading();
      return this.mark(stage, done, total);
    }
    const whole = STAGES.reduce((sum, { share }) => sum + share, 0);
    const before = STAGES.slice(0, Math.max(0, at)).reduce((sum, { share }) => sum + share, 0);
    const part = (before + ((STAGES[at]?.share ?? 0) * done) / Math.max(1, total)) / whole;
    const expected = Math.max(window + 1, Math.ceil((this.take.frames - OVERLAP) / (WINDOW - OVERLAP)));
    // Not the last step: that is done when everything is collected.
    this.mark('windows', Math.min(expected - 0.01, window + part), expected);
  }

  async add(window: WindowResult) {
    // A frame of the next window is read before a window is computed.
    const isLast = window.firstFrame + window.settled.to === this.images.length;
    this.streaming ||= !isLast;
    this.settling = this.settle(window);
    await inSlices(this.settling);
    if (!isLast && !this.stopped) this.onWindow();
  }

  /** A frame a step. */
  *settle(window: WindowResult) {
    this.presence ??= new Presence(window);
    if (window.shot > this.cuts.length) this.cuts.push(this.presence.frames.length);
    for (const { labels } of window.frames()) yield this.presence.addMask(labels);
  }

  /** What is settled by now is a result too. */
  stop() {
    this.video?.pause();
    while (!this.settling.next().done);
    this.stopped = true;
    this.masks = this.streaming ? (this.video?.collected ?? null) : null;
    return this.partial;
  }

  get partial() {
    return this.stopped && this.masks !== null;
  }

  /** Frames whose masks are settled while others are to come. */
  get settled() {
    return this.streaming ? (this.presence?.frames.length ?? 0) : 0;
  }

  /** What is settled so far, or the whole when it is. */
  get shown(): Shown {
    const { found, presence, session, corrections } = this;
    const result = corrections.over(found ? resultOf(found) : this.masksAsResult());
    if (!found || !session)
      return {
        ...{ result, presence, numbers: this.numbers, headline: countObjects, answers: {} },
        notice: (facts) => this.notice(facts),
      };
    return {
      ...{ result, presence },
      answers: { background: (t) => found.background(t) },
      numbers: [`${plural(this.images.length, 'frame')} of ${this.size}`],
      headline: (facts) => headline(found, facts),
      notice: () => remark(found),
    };
  }

  get numbers() {
    return this.inWindows ? [this.extent, LONG.remark(WINDOW)] : [this.extent];
  }

  /** Returns `120 frames of 480 × 270 in 3 windows and 2 shots`. */
  get extent(): string {
    const shots = this.cuts.length + 1;
    const windows = plural(this.windows, 'window');
    const pieces = shots > 1 ? `${windows} and ${plural(shots, 'shot')}` : windows;
    return `${plural(this.masks?.numFrames ?? this.settled, 'frame')} of ${this.size} in ${pieces}`;
  }

  notice(facts: Facts[]) {
    if (this.partial) return LONG.partial(this.settled, this.take.frames);
    const some = facts.some(({ object, first }) => object > 0 && first >= 0);
    return some || !this.masks ? '' : LONG.nothing;
  }

  /** Returns the masks, in the form that the page's layers look at; trajectories come with the whole result. */
  masksAsResult(): ShownResult {
    const { masks, video } = this;
    const { width, height } = masks ?? this.images;
    const trajectories = masks?.trajectories ?? NO_TRAJECTORIES;
    const highest = (this.presence?.frames ?? []).reduce((most, { n }) => Math.max(most, n.length - 1), 0);
    const objects = masks?.objects ?? Array.from({ length: highest }, (_, k) => ({ label: k + 1 }));
    return {
      ...{ width, height },
      numFrames: masks?.numFrames ?? this.settled,
      trajectories,
      objects,
      labels: (t) => (masks ?? video)!.labels(t),
      toTracksDat: () => {
        if (!masks) throw new PageError('unfinished');
        return masks.toTracksDat();
      },
    };
  }

  close() {
    this.corrections.close();
    this.life.abort();
    this.session?.close();
    super.close();
  }
}

function resultOf(found: Result): ShownResult {
  const { width, height, numFrames, trajectories, clusters } = found;
  const objectOf = clusters.object!;
  const label = Uint8Array.from(clusters.label, (cluster) => objectOf[cluster]);
  return {
    ...{ width, height, numFrames, clusters, objects: found.objects ?? [] },
    trajectories: { ...trajectories, label },
    labels: (t) => found.labels(t),
    toTracksDat: () => found.toTracksDat(),
  };
}
