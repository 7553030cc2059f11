/** What a run over a clip and one over a still image have in common. @module */

import { FrameStore } from './frame-store.js';
import { StageClock } from './stage-clock.js';

/** @typedef {import('./source.js').Source} Source */
/** @typedef {import('./source.js').Take} Take */
/** @typedef {Record<string, Record<string, number | boolean | string>>} Options Parameters that differ from their defaults. */

/**
 * What a run over a clip has found, as the page shows it.
 *
 * @typedef {object} Shown
 * @property {import('./points.js').Result} result
 * @property {import('./presence.js').Presence | null} presence where each object is, if that is known already
 * @property {boolean} windows whether the clip was taken window by window
 * @property {Partial<import('./layer.js').Answers>} answers
 * @property {string[]} numbers for the line of facts
 */

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
    /** The frames as they are shown. */
    this.images = new FrameStore();
    /** @type {number[]} When they are shown, in seconds; none where nobody knows. */
    this.times = [];
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

  /** @returns {string} of its frames: `480 × 270` */
  get size() {
    return `${this.images.width} × ${this.images.height}`;
  }

  /** Frees what it holds. */
  close() {
    this.images.close();
  }
}

/**
 * Superpixels serve two layers; each frame's are fetched once.
 *
 * @template T
 * @param {(frame: number) => Promise<T>} ask
 * @returns {(frame: number) => Promise<T>}
 */
export function remembered(ask) {
  /** @type {Map<number, Promise<T>>} */
  const known = new Map();
  return (frame) => {
    const answer = known.get(frame) ?? ask(frame);
    known.set(frame, answer);
    return answer;
  };
}
