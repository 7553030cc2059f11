/** What a run over a clip and one over a still image have in common. @module */

import { StageClock } from './stage-clock.js';

/** @typedef {import('./source.js').Source} Source */
/** @typedef {import('./source.js').Take} Take */
/** @typedef {Record<string, Record<string, number | boolean | string>>} Options Parameters that differ from their defaults. */

export class Run extends StageClock {
  /**
   * @param {any} library the tracecut package
   * @param {Source} source
   * @param {Take} take
   * @param {Options} options
   * @param {import('./stage-clock.js').StagePlan[]} plan
   */
  constructor(library, source, take, options, plan) {
    super(plan);
    this.library = library;
    this.source = source;
    this.take = take;
    this.options = options;
    /** @type {ImageBitmap[]} The frames as they are shown. */
    this.images = [];
    /** @type {any} */
    this.result = null;
    /** @type {import('./correct.js').Corrector | null} What can be corrected of the result. */
    this.corrector = null;
  }

  /**
   * @param {Take} take
   * @param {Options} options
   * @returns {boolean} whether this is a run with these settings
   */
  isFor(take, options) {
    return JSON.stringify([take, options]) === JSON.stringify([this.take, this.options]);
  }

  /** Frees what it holds. */
  close() {
    for (const image of this.images.splice(0)) image.close();
  }
}
