/**
 * A run over a clip of more frames than fit into one window: windows of frames are segmented one after the other, and
 * what is settled is shown at once. Objects keep their numbers from window to window.
 * @module
 */

import { CLIP_STAGES } from './clip-job.js';
import { MaskStore } from './mask-store.js';
import { Presence } from '../result/presence.js';
import { LONG, PageError, countObjects, plural } from '../words.js';
import { LongCorrections } from './corrections.js';
import { Job, remembered } from './job.js';
import { inSlices } from './slices.js';
import { untilAborted } from './stage-clock.js';
import { say } from '../language.js';

/** @typedef {import('../../dist/index.js').VideoResult} VideoResult */

/** Frames that are segmented together, and how many of them the next window shares. A clip that fits is a `ClipJob`. */
export const WINDOW = 50;
const OVERLAP = 10;

const NO_TRAJECTORIES = {
  count: 0,
  startFrame: new Uint32Array(0),
  offset: new Uint32Array(1),
  x: new Float32Array(0),
  y: new Float32Array(0),
  label: new Uint8Array(0),
};

/** @type {import('./stage-clock.js').StagePlan[]} */
export const LONG_STAGES = [
  { id: 'windows', name: 'Segmenting window by window', share: 0.9 },
  { id: 'frames', name: 'Reading frames', share: 0.1 },
];

export class LongJob extends Job {
  static stages = LONG_STAGES;

  /**
   * @param {import('../source.js').Source} source
   * @param {import('../source.js').Take} take
   */
  static fits(source, take) {
    return source.kind !== 'still' && take.frames > WINDOW;
  }

  /** @param {ConstructorParameters<typeof Job>} parts */
  constructor(...parts) {
    super(...parts);
    /** @type {import('../../dist/index.js').VideoSegmentation | null} */
    this.video = null;
    /** @type {Promise<void>} The work that `video` does; it waits while the run is stopped. */
    this.working = Promise.resolve();
    this.life = new AbortController();
    this.report = () => {};
    this.onWindow = () => {};
    /** @type {VideoResult | null} Of the whole clip, or of what was settled when the run was stopped. */
    this.result = null;
    this.stopped = false;
    /** @type {MaskStore | null} What is settled so far. */
    this.masks = null;
    this.windows = 0;
    /** @type {Iterator<unknown>} What the package has settled, on its way to `masks` and `presence`. */
    this.settling = [].values();
    this.corrections = new LongCorrections(
      { library: this.library, masks: () => this.result, images: this.images, cuts: () => this.cuts },
      () => this.whole(),
      (result) => void (this.result = result),
    );
    /** @type {import('./job.js').Corrector | null} */
    this.corrector = this.corrections;
  }

  /** Its two stages go on side by side: their times say nothing about the next run. @returns {null} */
  get measured() {
    return null;
  }

  /** @returns {VideoResult} the whole clip's result, which can be corrected */
  whole() {
    if (!this.result || this.stopped) throw new PageError('unfinished');
    return this.result;
  }

  /**
   * Runs to the end, from where it was stopped.
   *
   * @param {AbortSignal} signal
   * @param {() => void} report called after each step
   * @param {() => void} onWindow called when more frames are settled
   */
  async run(signal, report, onWindow) {
    Object.assign(this, { report, onWindow, stopped: false, result: null, corrector: this.corrections });
    this.corrections.clear();
    this.start();
    if (this.video) this.video.resume();
    else this.working = this.work();
    await untilAborted(this.working, signal);
  }

  async work() {
    const video = this.library.segmentVideo(this.frames(), {
      ...this.options,
      window: WINDOW,
      overlap: OVERLAP,
      frameRate: this.source.fps / this.take.step,
      signal: this.life.signal,
      onProgress: (progress) => {
        this.advance(progress);
        if (!this.stopped) this.report();
      },
    });
    this.video = video;
    const result = await video.collect(async (window) => {
      this.settling = this.settle(window);
      await inSlices(this.settling);
      if (!this.stopped) this.onWindow();
    });
    this.mark('windows', 1, 1);
    this.mark('frames', this.images.length, this.images.length);
    this.result = result;
  }

  get waited() {
    return WINDOW;
  }

  async *frames() {
    const { signal } = this.life;
    for await (const { frame, time, end = null } of this.source.frames(this.take, signal)) {
      signal.throwIfAborted();
      await this.arrived(frame, time, end);
      this.mark('frames', this.images.length, Math.max(this.take.frames, this.images.length + 1));
      if (!this.stopped) this.report();
      if (time === null) yield frame;
      else yield end === null ? { frame, time } : { frame, time, duration: end - time };
    }
  }

  /** @param {{stage: string, done: number, total: number, window: number}} progress */
  advance({ stage, done, total, window }) {
    this.windows = Math.max(this.windows, window + 1);
    const at = CLIP_STAGES.findIndex(({ id }) => id === stage);
    const whole = CLIP_STAGES.reduce((sum, { share }) => sum + share, 0);
    const before = CLIP_STAGES.slice(0, Math.max(0, at)).reduce((sum, { share }) => sum + share, 0);
    const part = (before + ((CLIP_STAGES[at]?.share ?? 0) * done) / Math.max(1, total)) / whole;
    const expected = Math.max(window + 1, Math.ceil((this.take.frames - OVERLAP) / (WINDOW - OVERLAP)));
    // Not the last step: that is done when everything is collected.
    this.mark('windows', Math.min(expected - 0.01, window + part), expected);
  }

  /**
   * A frame a step.
   *
   * @param {import('../../dist/index.js').WindowResult} window
   */
  *settle(window) {
    const { width, height } = window;
    this.masks ??= new MaskStore(width, height);
    this.presence ??= new Presence({ width, height });
    if (window.shot > this.cuts.length) this.cuts.push(this.presence.frames.length);
    for (const { labels } of window.frames()) {
      this.masks.add(labels);
      this.presence.addMask(labels);
      yield;
    }
  }

  /** What is settled by now is a result too. */
  stop() {
    this.video?.pause();
    while (!this.settling.next().done);
    this.stopped = true;
    this.result = this.video?.collected ?? null;
    if (this.result) this.corrector = null;
    return this.partial;
  }

  get partial() {
    return this.stopped && this.result !== null;
  }

  /** Frames whose masks are settled. */
  get settled() {
    return this.presence?.frames.length ?? 0;
  }

  /**
   * @param {number[] | null} frames
   * @param {import('../result/points.js').Points} points
   */
  recount(frames, points) {
    super.recount(frames, points);
    const { masks } = this.corrections;
    if (frames || !masks) return;
    this.presence = new Presence(masks);
    for (let t = 0; t < masks.numFrames; t++) this.presence.addMask(masks.labels(t));
  }

  /** What is settled so far, or the whole when it is. @returns {import('./job.js').Shown} */
  get shown() {
    const { library } = this;
    const { contour, superpixel } = this.options;
    return {
      result: this.masksAsResult(),
      presence: this.presence,
      windows: true,
      answers: {
        boundaries: async (t) => library.boundaries(await this.picture(t)),
        superpixels: remembered(async (/** @type {number} */ t) =>
          library.superpixels(await this.picture(t), { contour, superpixel }),
        ),
      },
      numbers: [this.extent],
      headline: countObjects,
      notice: (facts) => this.notice(facts),
    };
  }

  /**
   * @param {number} t
   * @returns {Promise<ImageBitmap>}
   */
  async picture(t) {
    const picture = await this.images.open(t);
    if (!picture) throw new PageError('closed');
    return picture;
  }

  /** @returns {string} `120 frames of 480 × 270 in 3 windows and 2 shots` */
  get extent() {
    const shots = this.cuts.length + 1;
    const windows = plural(this.windows, 'window');
    const pieces = shots > 1 ? say`${windows} and ${plural(shots, 'shot')}` : windows;
    return say`${plural(this.settled, 'frame')} of ${this.size} in ${pieces}`;
  }

  /** @param {import('./job.js').Facts[]} facts */
  notice(facts) {
    if (this.partial) return LONG.partial(this.settled, this.take.frames);
    const some = facts.some(({ object, first }) => object > 0 && first >= 0);
    return some || !this.result ? say(LONG.remark) : say(LONG.nothing);
  }

  /**
   * @returns {import('../result/points.js').Result} the masks, in the form that the page's layers look at; trajectories come
   *   with the whole result
   */
  masksAsResult() {
    const { presence, settled } = this;
    const masks = /** @type {MaskStore} */ (this.masks);
    const { width, height } = masks;
    const none = new Uint32Array(0);
    const trajectories = this.result?.trajectories ?? NO_TRAJECTORIES;
    const count = (presence?.frames ?? []).reduce((most, { n }) => Math.max(most, n.length - 1), 0);
    return {
      width,
      height,
      numFrames: this.result?.numFrames ?? settled,
      trajectories,
      // Each object is one cluster: over many windows there are no others.
      clusters: {
        count: count + 1,
        label: Uint32Array.from(trajectories.label),
        object: Uint8Array.from({ length: count + 1 }, (_, object) => object),
      },
      objects: Array.from({ length: count }, (_, k) => ({ label: k + 1 })),
      saliency: null,
      components: null,
      embedding: { dimensions: 0, eigenvalues: new Float64Array(0), vectors: new Float32Array(0) },
      labels: (t) => (this.corrections.masks ?? masks).labels(t),
      edges: () => ({ i: none, j: none, d: new Float32Array(0) }),
      toTracksDat: () => {
        if (!this.result) throw new PageError('unfinished');
        return this.result.toTracksDat();
      },
    };
  }

  close() {
    this.corrections.close();
    this.life.abort();
    super.close();
  }
}
