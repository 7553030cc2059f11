/**
 * One run: frames of a source into a session, the session to its end, and the time that each stage took. A cancelled
 * run may be run again and goes on where it was.
 * @module
 */

import { Run, remembered } from './run.js';
import { untilAborted } from './stage-clock.js';
import { PageError, plural } from './words.js';

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

export class Job extends Run {
  /**
   * @param {any} library the tracecut package
   * @param {import('./source.js').Source} source
   * @param {import('./source.js').Take} take
   * @param {import('./run.js').Options} options
   * @param {import('./stage-clock.js').StagePlan[]} plan
   */
  constructor(library, source, take, options, plan) {
    super(library, source, take, options, plan);
    /** @type {any} */
    this.session = null;
    this.allPushed = false;
    /** @type {import('./correct.js').Corrector} */
    this.corrector = {
      merge: (a, b) => this.corrected(this.session.merge(a, b)),
      split: (label, at) => this.corrected(this.session.split(label, at)),
      together: (strokes) => this.corrected(this.session.together(strokes)),
      apart: (strokes) => this.corrected(this.session.apart(strokes)),
      undo: () => this.corrected(this.session.undo()),
      count: () => this.session?.corrections ?? 0,
    };
    /** @type {Promise<unknown>} */
    this.settled = Promise.resolve();
  }

  /**
   * Runs to the end. Rejects with the signal's reason as soon as it is aborted, without waiting for the worker.
   *
   * @param {AbortSignal} signal
   * @param {(job: Job) => void} report called after each step
   * @returns {Promise<any>} the session's result
   */
  async run(signal, report) {
    await untilAborted(this.settled, signal);
    const work = this.work(signal, report);
    this.settled = work.catch(() => {});
    return untilAborted(work, signal);
  }

  /**
   * @param {AbortSignal} signal
   * @param {(job: Job) => void} report
   */
  async work(signal, report) {
    this.start();
    if (!this.allPushed) await this.pushFrames(signal, report);
    this.result = await this.session.run({
      signal,
      onProgress: (/** @type {any} */ step) => {
        if (signal.aborted) return;
        this.mark(step.stage, step.done, step.total);
        report(this);
      },
    });
    return this.result;
  }

  /**
   * @param {AbortSignal} signal
   * @param {(job: Job) => void} report
   */
  async pushFrames(signal, report) {
    this.session?.close();
    this.images.clear();
    this.times = [];
    this.stages[0].ms = 0;
    this.session = await this.library.createSession(this.options);
    for await (const { frame, time } of this.source.frames(this.take, signal)) {
      signal.throwIfAborted();
      // The picture is copied before the session gets the bytes, which it may hand on to its worker.
      await this.images.add(frame);
      if (time !== null) this.times.push(time);
      await this.session.push(frame);
      this.mark('frames', this.images.length, this.take.frames);
      report(this);
    }
    signal.throwIfAborted();
    if (this.images.length === 0) throw new PageError('no-frames');
    if (this.images.length === 1) throw new PageError('one-frame');
    this.stages[0].total = this.images.length;
    this.allPushed = true;
  }

  /** @returns {import('./run.js').Shown} */
  get shown() {
    const { result, session } = this;
    const superpixels = remembered((/** @type {number} */ t) => result.superpixels(t));
    return {
      result,
      presence: null,
      windows: false,
      answers: {
        flow: (t) => session.flow(t),
        boundaries: (t) => result.boundaries(t),
        superpixels: result.objects && superpixels,
        saliencyMap: (t) => result.saliencyMap(t),
      },
      numbers: [plural(result.trajectories.count, 'trajectory', 'trajectories'), `${plural(this.images.length, 'frame')} of ${this.size}`],
    };
  }

  /** @param {Promise<any>} result */
  async corrected(result) {
    this.result = await result;
  }

  close() {
    this.session?.close();
    super.close();
  }
}
