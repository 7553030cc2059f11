/** What all kinds of runs have in common, and what the page may ask of them. @module */

import { Preview, isWorth } from './preview.js';
import { StageClock } from './stage-clock.js';

/** @typedef {import('./source.js').Source} Source */
/** @typedef {import('./source.js').Take} Take */
/** @typedef {import('./library.js').SessionOptions} Options Parameters that differ from their defaults. */
/** @typedef {import('./presence.js').Facts} Facts */

/**
 * What a run has found so far, as the page shows it.
 *
 * @typedef {object} Shown
 * @property {import('./points.js').Result | null} result null for a still image
 * @property {import('./presence.js').Presence | null} presence where each object is, if that is known already
 * @property {Partial<import('./answers.js').Answers>} answers
 * @property {string[]} numbers for the line of facts
 * @property {(facts: Facts[]) => string} headline
 * @property {(facts: Facts[]) => string} notice what else there is to say, empty for nothing
 */

/** What is to be painted, where. @typedef {Parameters<import('./library.js').MaskEditor['paint']>[0]} ToPaint */

/**
 * Something painted, and the frames that have it.
 *
 * @typedef {{edit: import('./library.js').Edit, frames: number[]}} Painted
 */

/**
 * Runs of clips and of still images, each with `run`, `shown` and the static `stagesFor`.
 *
 * @typedef {import('./clip-job.js').ClipJob | import('./still-job.js').StillJob} AnyJob
 */

/**
 * The frames of a run as they are shown.
 *
 * @typedef {import('./store.js').Frames & {length: number, width: number, height: number, add: (frame: ImageData) =>
 *   Promise<void>, open: (t: number) => Promise<CanvasImageSource | null>, pixels: (t: number, size: {width: number,
 *   height: number}) => Promise<ImageData>, close: () => void}} Images
 */

/** Runs of this page. */
let runs = 0;

export class Job extends StageClock {
  /**
   * @param {Source} source
   * @param {Take} take
   * @param {Options} options
   * @param {import('./stage-clock.js').StagePlan[]} plan
   * @param {Images} images an empty list of frames
   */
  constructor(source, take, options, plan, images) {
    super(plan);
    /** Which run the result is of, in this page and others. */
    this.id = `${Date.now()}-${(runs += 1)}`;
    this.source = source;
    this.take = take;
    this.options = options;
    /** The frames as they are shown. */
    this.images = images;
    /** @type {number[]} When they are shown, in seconds; none where nobody knows. */
    this.times = [];
    /** @type {Preview | null} What is shown until the first masks are there. */
    this.preview = null;
    /** @type {number | null} When the last of them ends. */
    this.end = null;
    /** @type {number[]} First frames of further shots. */
    this.cuts = [];
    /** @type {import('./corrections.js').Corrections | null} Of the result, where it can be corrected. */
    this.corrections = null;
    /** What of the corrections of the run before no longer applies, in words. */
    this.lost = '';
    /** @type {import('./presence.js').Presence | null} Where objects are, as far as that is counted. */
    this.presence = null;
  }

  /** Whether the result comes from a run which was stopped early, and can go on. */
  get partial() {
    return false;
  }

  /** What corrects the result on screen; a part of a clip stays as it is. */
  get corrector() {
    return this.partial ? null : this.corrections;
  }

  /** Whether there is something in the result that another run would not have. */
  get isCorrected() {
    return false;
  }

  /** Frames that are settled while others are still to come. */
  get settled() {
    return 0;
  }

  /**
   * After a cancel: keeps what is settled as the result, where that is one.
   *
   * @returns {boolean} whether it is; either way the run may be run again, and goes on where it was
   */
  stop() {
    return false;
  }

  /**
   * After a correction: where each object is now.
   *
   * @param {number[] | null} frames those that changed; null for all
   * @param {import('./points.js').Points} points of the result before
   */
  recount(frames, points) {
    this.presence = frames && points.presence;
    const masks = this.corrections?.masks;
    if (masks) frames?.forEach((t) => points.presence.addMask(masks.labels(t), t));
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

  /** Begins a preview, if the masks take so long that it is worth one. */
  look() {
    if (isWorth(this.source, this.take)) this.preview = new Preview(this.options);
  }

  /**
   * A frame has been read.
   *
   * @param {ImageData} frame
   * @param {number | null} time
   * @param {number | null} end when it is over, where that is known
   */
  async arrived(frame, time, end) {
    // The picture is copied before others get the bytes, who may hand them on to a worker.
    await this.images.add(frame);
    if (time !== null) this.times.push(time);
    this.end = end;
    this.preview?.add(frame);
  }

  /** Frees what it holds. */
  close() {
    this.preview?.close();
    this.images.close();
  }
}
