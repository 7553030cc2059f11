/**
 * One run over a single image: no motion, so what is found are boundaries, superpixels and the discontinuities of an embedding of its
 * pixels. Each is made in a worker. A cancelled run may be run again and goes on with what is missing.
 * @module
 */

import { Run } from './run.js';
import { untilAborted } from './stage-clock.js';

/** @typedef {import('./layer.js').Boundaries} Boundaries */
/** @typedef {import('./layer.js').Superpixels} Superpixels */
/** @typedef {import('./layer.js').ImageEdges} ImageEdges */

/** @type {import('./stage-clock.js').StagePlan[]} */
export const STILL_STAGES = [
  { id: 'frames', name: 'Reading the image', share: 0.02 },
  { id: 'boundaries', name: 'Boundaries', share: 0.1 },
  { id: 'superpixels', name: 'Superpixels', share: 0.13 },
  { id: 'imageEdges', name: 'Pixel embedding', share: 0.75 },
];

export class StillJob extends Run {
  /**
   * @param {any} library the tracecut package
   * @param {import('./source.js').Source} source
   * @param {import('./source.js').Take} take
   * @param {import('./run.js').Options} options
   * @param {import('./stage-clock.js').StagePlan[]} plan
   */
  constructor(library, source, take, options, plan) {
    super(library, source, take, options, plan);
    /** @type {ImageData | null} */
    this.pixels = null;
    /** @type {{boundaries?: Boundaries, superpixels?: Superpixels, imageEdges?: ImageEdges}} What has been found. */
    this.found = {};
    /** @type {Map<string, Promise<any>>} What is being looked for, a cancelled run's too. */
    this.asked = new Map();
  }

  /**
   * Runs to the end. Rejects with the signal's reason as soon as it is aborted; the worker of that moment ends its work alone.
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
    const { library, pixels } = this;
    const { contour, superpixel, still } = this.options;
    for (const [id, make] of /** @type {const} */ ([
      ['boundaries', () => library.boundaries(pixels, { contour })],
      ['superpixels', () => library.superpixels(pixels, { contour, superpixel })],
      ['imageEdges', () => library.imageDiscontinuities(pixels, { contour, still })],
    ])) {
      this.found[id] = await this.once(id, make);
      signal.throwIfAborted();
      this.mark(id, 1, 1);
      report();
    }
  }

  async read() {
    const pixels = await this.source.preview(0, this.take.side);
    await this.images.add(pixels);
    this.mark('frames', 1, 1);
    return pixels;
  }

  /**
   * @param {string} id
   * @param {() => Promise<any>} make
   * @returns {Promise<any>} of the first call, unless that failed
   */
  async once(id, make) {
    const answer = this.asked.get(id) ?? make();
    this.asked.set(id, answer);
    try {
      return await answer;
    } catch (error) {
      this.asked.delete(id);
      throw error;
    }
  }
}
