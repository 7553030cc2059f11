/**
 * One run: frames of a source into a session, the session to its end, and the time that each stage took. A cancelled
 * run may be run again and goes on where it was.
 * @module
 */

import { Presence } from '../result/presence.js';
import { PageError, headline, plural, remark } from '../words.js';
import { SessionCorrections } from './corrections.js';
import { Job, remembered } from './job.js';
import { inSlices } from './slices.js';
import { untilAborted } from './stage-clock.js';
import { say } from '../language.js';

/**
 * Stages in order, with the share of the whole time that each usually takes; after a run, its own shares are taken.
 *
 * @type {import('./stage-clock.js').StagePlan[]}
 */
export const CLIP_STAGES = [
  { id: 'frames', name: 'Reading frames', share: 0.14 },
  { id: 'flow', name: 'Optical flow', share: 0.33 },
  { id: 'trajectories', name: 'Trajectories', share: 0.12 },
  { id: 'affinities', name: 'Motion affinities', share: 0.02 },
  { id: 'embedding', name: 'Embedding', share: 0.04 },
  { id: 'discontinuities', name: 'Discontinuities', share: 0.02 },
  { id: 'saliency', name: 'Saliency', share: 0.06 },
  { id: 'connectedness', name: 'Connectedness', share: 0.03 },
  { id: 'clusters', name: 'Clusters', share: 0.03 },
  { id: 'superpixels', name: 'Superpixels', share: 0.16 },
  { id: 'cut', name: 'Gabriel cut', share: 0.05 },
  { id: 'masks', name: 'Masks', share: 0.07 },
];

/** @typedef {import('../../dist/index.js').Result} Result */

export class ClipJob extends Job {
  static stages = CLIP_STAGES;

  /** Whatever no other kind takes. */
  static fits() {
    return true;
  }

  /** @param {ConstructorParameters<typeof Job>} parts */
  constructor(...parts) {
    super(...parts);
    /** @type {import('../../dist/index.js').Session | null} */
    this.session = null;
    /** @type {Result | null} */
    this.result = null;
    this.allPushed = false;
    this.corrections = new SessionCorrections(
      { library: this.library, masks: () => this.result, images: this.images, cuts: () => this.cuts },
      () => this.opened,
      async (result) => void (this.result = await result),
    );
    this.corrector = this.corrections;
    /** @type {Promise<unknown>} What a cancelled run still does. */
    this.ending = Promise.resolve();
  }

  /** @returns {import('../../dist/index.js').Session} */
  get opened() {
    if (!this.session) throw new PageError('closed');
    return this.session;
  }

  /**
   * Runs to the end. Rejects with the signal's reason as soon as it is aborted, without waiting for the worker.
   *
   * @param {AbortSignal} signal
   * @param {() => void} report called after each step
   */
  async run(signal, report) {
    await untilAborted(this.ending, signal);
    const work = this.work(signal, report);
    this.ending = work.catch(() => {});
    await untilAborted(work, signal);
  }

  /**
   * @param {AbortSignal} signal
   * @param {() => void} report
   */
  async work(signal, report) {
    this.start();
    this.corrections.clear();
    this.presence = null;
    if (!this.allPushed) await this.pushFrames(signal, report);
    this.result = await this.opened.run({
      signal,
      onProgress: ({ stage, done, total }) => {
        if (signal.aborted) return;
        this.mark(stage, done, total);
        report();
      },
    });
    if (this.result.objects) await inSlices(this.count(this.result));
  }

  /**
   * Where objects are, a frame a step.
   *
   * @param {Result} result
   */
  *count(result) {
    const presence = new Presence(result);
    for (let t = 0; t < result.numFrames; t++) yield presence.addMask(result.labels(t));
    this.presence = presence;
  }

  /**
   * @param {AbortSignal} signal
   * @param {() => void} report
   */
  async pushFrames(signal, report) {
    this.session?.close();
    this.images.clear();
    this.times = [];
    this.stages[0].ms = 0;
    const session = await this.library.createSession(this.options);
    this.session = session;
    for await (const { frame, time, end = null } of this.source.frames(this.take, signal)) {
      signal.throwIfAborted();
      await this.arrived(frame, time, end);
      await session.push(frame);
      this.mark('frames', this.images.length, this.take.frames);
      report();
    }
    signal.throwIfAborted();
    if (this.images.length === 0) throw new PageError('no-frames');
    if (this.images.length === 1) throw new PageError('one-frame');
    this.stages[0].total = this.images.length;
    this.allPushed = true;
  }

  /** @returns {import('./job.js').Shown} */
  get shown() {
    const { result, opened: session } = this;
    if (!result) throw new PageError('unfinished');
    const { corrections } = this;
    return {
      result: corrections.over(result),
      presence: this.presence,
      windows: false,
      answers: {
        flow: (t) => session.flow(t),
        boundaries: (t) => result.boundaries(t),
        superpixels: result.objects && remembered((/** @type {number} */ t) => result.superpixels(t)),
        background: result.objects && ((t) => result.background(t)),
        saliencyMap: (t) => result.saliencyMap(t),
        // A correction of the session leaves them to its own result.
        explain: result.objects && ((t, x, y) => (this.result ?? result).explain(t, x, y)),
        confidence: result.objects && ((t) => (this.result ?? result).confidence(t)),
      },
      numbers: [
        plural(result.trajectories.count, 'trajectory', 'trajectories'),
        say`${plural(this.images.length, 'frame')} of ${this.size}`,
      ],
      headline: (facts) => headline(result, facts),
      notice: () => remark(result),
    };
  }

  close() {
    this.corrections.close();
    this.session?.close();
    super.close();
  }
}
