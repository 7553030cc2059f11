/**
 * One run over a single image: no motion, so what is found are boundaries, superpixels and the discontinuities of an
 * embedding of its pixels. Each is made in a worker. A cancelled run may be run again and goes on with what is missing.
 * @module
 */

import { boundaries, imageDiscontinuities, superpixels } from './library.js';
import { STILL, plural } from './words.js';
import { Job } from './job.js';
import { untilAborted } from './stage-clock.js';

/** @typedef {import('./answers.js').Boundaries} Boundaries */
/** @typedef {import('./answers.js').Superpixels} Superpixels */
/** @typedef {import('./answers.js').ImageEdges} ImageEdges */

/** @type {import('./stage-clock.js').StagePlan[]} */
const STAGES = [
  { id: 'frames', share: 0.02 },
  { id: 'boundaries', share: 0.1 },
  { id: 'superpixels', share: 0.13 },
  { id: 'imageEdges', share: 0.75 },
];

/** @typedef {{boundaries?: Boundaries, superpixels?: Superpixels, imageEdges?: ImageEdges}} Finds */

export class StillJob extends Job {
  static stagesFor() {
    return STAGES;
  }

  /** @param {ConstructorParameters<typeof Job>} parts */
  constructor(...parts) {
    super(...parts);
    /** @type {ImageData | null} */
    this.pixels = null;
    /** @type {Finds} What has been found. */
    this.found = {};
    /** @type {Map<string, Promise<unknown>>} What is being looked for, a cancelled run's too. */
    this.asked = new Map();
  }

  /**
   * Runs to the end. Rejects with the signal's reason as soon as it is aborted; the worker of that moment ends its work
   * alone.
   *
   * @param {AbortSignal} signal
   * @param {() => void} report called after each step
   */
  run(signal, report) {
    return untilAborted(this.work(signal, report), signal);
  }

  /**
   * @param {AbortSignal} signal
   * @param {() => void} report
   */
  async work(signal, report) {
    this.start();
    this.pixels ??= await this.read();
    signal.throwIfAborted();
    report();
    const { pixels } = this;
    const { contour, superpixel, still } = this.options;
    /** @type {<K extends keyof Finds>(id: K, make: () => Promise<NonNullable<Finds[K]>>) => Promise<void>} */
    const find = async (id, make) => {
      this.found[id] = await this.once(id, make);
      signal.throwIfAborted();
      this.mark(id, 1, 1);
      report();
    };
    await find('boundaries', () => boundaries(pixels));
    await find('superpixels', () => superpixels(pixels, { contour, superpixel }));
    await find('imageEdges', () => imageDiscontinuities(pixels, { still }));
  }

  async read() {
    const pixels = await this.source.preview(0, this.take.side);
    await this.images.add(pixels);
    this.mark('frames', 1, 1);
    return pixels;
  }

  /**
   * @template T
   * @param {string} id
   * @param {() => Promise<T>} make
   * @returns {Promise<T>} of the first call, unless that failed
   */
  async once(id, make) {
    const answer = /** @type {Promise<T> | undefined} */ (this.asked.get(id)) ?? make();
    this.asked.set(id, answer);
    try {
      return await answer;
    } catch (error) {
      this.asked.delete(id);
      throw error;
    }
  }

  /** @returns {import('./job.js').Shown} */
  get shown() {
    const { boundaries, superpixels, imageEdges } = this.found;
    return {
      result: null,
      presence: null,
      answers: {
        boundaries: boundaries ? async () => boundaries : null,
        superpixels: superpixels ? async () => superpixels : null,
        imageEdges: imageEdges ? async () => imageEdges : null,
      },
      numbers: [plural(superpixels?.count ?? 0, 'superpixel'), this.size],
      headline: () => STILL.headline,
      notice: () => STILL.remark,
    };
  }
}
