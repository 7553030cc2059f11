/**
 * One run: frames of a source into a session, the session to its end, and the time that each stage took. A cancelled
 * run may be run again and goes on where it was.
 * @module
 */

import { PageError } from './words.js';

/** @typedef {import('./source.js').Source} Source */
/** @typedef {import('./source.js').Take} Take */

/**
 * Stages in order, with the share of the whole time that each usually takes (only for the bar of the whole).
 *
 * @type {{id: string, name: string, share: number}[]}
 */
export const STAGES = [
  { id: 'frames', name: 'Reading frames', share: 0.14 },
  { id: 'flow', name: 'Optical flow', share: 0.52 },
  { id: 'trajectories', name: 'Trajectories', share: 0.06 },
  { id: 'affinities', name: 'Motion affinities', share: 0.1 },
  { id: 'embedding', name: 'Embedding', share: 0.08 },
  { id: 'discontinuities', name: 'Discontinuities', share: 0.03 },
  { id: 'saliency', name: 'Saliency', share: 0.05 },
  { id: 'connectedness', name: 'Connectedness', share: 0.05 },
  { id: 'clusters', name: 'Clusters', share: 0.07 },
  { id: 'superpixels', name: 'Superpixels', share: 0.3 },
  { id: 'cut', name: 'Gabriel cut', share: 0.1 },
  { id: 'masks', name: 'Masks', share: 0.02 },
];

/** @typedef {{id: string, name: string, share: number, done: number, total: number, ms: number}} StageState */

export class Job {
  /**
   * @param {any} library the tracecut package
   * @param {Source} source
   * @param {Take} take
   */
  constructor(library, source, take) {
    this.library = library;
    this.source = source;
    this.take = take;
    /** @type {ImageBitmap[]} */
    this.images = [];
    /** @type {StageState[]} */
    this.stages = STAGES.map((stage) => ({ ...stage, done: 0, total: 0, ms: 0 }));
    /** @type {any} */
    this.session = null;
    /** @type {any} */
    this.result = null;
    this.allPushed = false;
    this.markedAt = 0;
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
    this.markedAt = performance.now();
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
    for (const image of this.images.splice(0)) image.close();
    this.stages[0].ms = 0;
    this.session = await this.library.createSession();
    for await (const frame of this.source.frames(this.take, signal)) {
      signal.throwIfAborted();
      // The picture is copied before the session gets the bytes, which it may hand on to its worker.
      this.images.push(await createImageBitmap(frame));
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

  /**
   * Books the time since the last step to this stage.
   *
   * @param {string} id
   * @param {number} done
   * @param {number} total
   */
  mark(id, done, total) {
    const now = performance.now();
    let stage = this.stages.find((s) => s.id === id);
    if (!stage) {
      stage = { id, name: id[0].toUpperCase() + id.slice(1), share: 0.05, done: 0, total: 0, ms: 0 };
      this.stages.push(stage);
    }
    stage.ms += now - this.markedAt;
    stage.done = done;
    stage.total = total;
    this.markedAt = now;
  }

  /** @returns {StageState | undefined} the stage under way: the first that is not through */
  get current() {
    return this.stages.find((stage) => stage.total === 0 || stage.done < stage.total);
  }

  /** @returns {number} in 0..1 */
  get share() {
    const whole = this.stages.reduce((sum, stage) => sum + stage.share, 0);
    const sum = this.stages.reduce((s, { share, done, total }) => s + (total > 0 ? (share * done) / total : 0), 0);
    return sum / whole;
  }

  /** @returns {number} milliseconds of all stages */
  get ms() {
    return this.stages.reduce((sum, stage) => sum + stage.ms, 0);
  }

  close() {
    this.session?.close();
    for (const image of this.images) image.close();
  }
}

/**
 * @template T
 * @param {Promise<T>} promise
 * @param {AbortSignal} signal
 * @returns {Promise<T>} settles with the promise, or rejects with the signal's reason if that comes first
 */
function untilAborted(promise, signal) {
  return new Promise((resolve, reject) => {
    if (signal.aborted) return reject(signal.reason);
    signal.addEventListener('abort', () => reject(signal.reason), { once: true });
    promise.then(resolve, reject);
  });
}
