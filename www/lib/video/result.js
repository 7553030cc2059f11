import { TraceCutError, illegal } from '../errors.js';
import { isPlainObject, wholeNumber } from '../options.js';
import { breath } from '../export/breath.js';
import { tracksDat } from '../tracks-dat.js';
import { areasOf, decodeRuns, encodeRuns } from './masks.js';
import { TrackCollector } from './tracks.js';

/**
 * An object of a clip: its label in the masks, the first and last frame it is in, the number of frames it is in, its
 * mean area over these in pixels, and its area in each frame of the clip.
 * @typedef {{label: number, firstFrame: number, lastFrame: number, frames: number, meanArea: number, areas:
 *   Uint32Array<ArrayBuffer>}} VideoObject
 */

/**
 * A stretch of frames without a cut, `first` and `last` included. Objects of different shots have different labels.
 * @typedef {{first: number, last: number}} Shot
 */

/**
 * @typedef {object} Collected
 * @property {number} width
 * @property {number} height
 * @property {Float64Array<ArrayBuffer>} times
 * @property {number | null} [end]
 * @property {Shot[]} shots
 * @property {Uint32Array<ArrayBuffer>[]} runs
 * @property {import('./tracks.js').ClipTrajectories} trajectories
 */

const NUM_LABELS = 256;
/** Frames between two breaths. */
const BATCH = 8;

/** The masks, objects and trajectories of a whole clip; made by `collect`. Its masks lie run-length coded in memory. */
export class VideoResult {
  #collected;
  #table;

  /**
   * @param {Collected} collected
   * @param {Uint8Array} table what each collected label is called now
   */
  constructor(collected, table = Uint8Array.from({ length: NUM_LABELS }, (_, label) => label)) {
    /** Width of the masks in pixels. */
    this.width = collected.width;
    /** Height of the masks in pixels. */
    this.height = collected.height;
    /** Number of frames. */
    this.numFrames = collected.times.length;
    /** The time of each frame, in seconds. */
    this.times = collected.times;
    /** When the last frame ends, in seconds; null where nothing says. */
    this.end = collected.end ?? null;
    /** The shots of the clip, in order. */
    this.shots = collected.shots;
    /** Point trajectories over the whole clip, in pixels of the masks, each with its object. */
    this.trajectories = {
      ...collected.trajectories,
      label: collected.trajectories.label.map((label) => /** @type {number} */ (table[label])),
    };
    /** The objects, by their labels. */
    this.objects = objectsOf(collected.runs, table);
    this.#collected = collected;
    this.#table = table;
  }

  /**
   * The mask of frame `t`: one byte for each pixel, row by row; 0 is the background.
   * @param {number} t
   * @returns {Uint8Array<ArrayBuffer>}
   */
  labels(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    const runs = /** @type {Uint32Array} */ (this.#collected.runs[t]);
    return decodeRuns(runs, this.width * this.height, this.#table);
  }

  /**
   * The same with other labels, at no cost: `{3: 1}` makes 3 the same object as 1, `{3: 0}` makes it background. This
   * result stays as it is.
   * @param {Record<number, number>} map from present labels to others, both 0 to 255
   * @returns {VideoResult}
   */
  relabel(map) {
    if (!isPlainObject(map)) throw illegal('param', 'map', map, 'an object such as {3: 1}');
    for (const [from, to] of Object.entries(map)) {
      wholeNumber('param', 'a label of map', Number(from), 0, NUM_LABELS - 1);
      wholeNumber('param', `map[${from}]`, to, 0, NUM_LABELS - 1);
    }
    const table = this.#table.map((label) => map[label] ?? label);
    return new VideoResult(this.#collected, table);
  }

  /**
   * The same with object `b` taken for part of `a`; `merge(0, b)` makes it background.
   * @param {number} a
   * @param {number} b
   * @returns {VideoResult}
   */
  merge(a, b) {
    if (a !== 0) this.#checkObject('a', a);
    this.#checkObject('b', b);
    return this.relabel({ [b]: a });
  }

  /**
   * The trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
   * its label and length and, line by line, `x y frame`.
   * @returns {string}
   */
  toTracksDat() {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames });
  }

  /**
   * @param {string} name
   * @param {number} label
   */
  #checkObject(name, label) {
    if (this.objects.some((object) => object.label === label)) return;
    const labels = this.objects.map((object) => object.label).join(', ');
    throw illegal(
      'param',
      name,
      label,
      labels ? `the label of an object: ${labels}` : 'the label of an object; there are none',
    );
  }
}

/**
 * @param {Uint32Array<ArrayBuffer>[]} runs
 * @param {Uint8Array} table
 * @returns {VideoObject[]}
 */
function objectsOf(runs, table) {
  /** @type {Map<number, Uint32Array<ArrayBuffer>>} */
  const areas = new Map();
  runs.forEach((frame, t) => {
    areasOf(frame).forEach((area, label) => {
      const called = /** @type {number} */ (table[label]);
      if (area === 0 || called === 0) return;
      if (!areas.has(called)) areas.set(called, new Uint32Array(runs.length));
      const own = /** @type {Uint32Array} */ (areas.get(called));
      own[t] = /** @type {number} */ (own[t]) + area;
    });
  });
  return [...areas].sort(([a], [b]) => a - b).map(([label, own]) => ({ label, ...presence(own), areas: own }));
}

/** @param {Uint32Array} areas */
function presence(areas) {
  const present = [...areas.keys()].filter((t) => areas[t]);
  const sum = areas.reduce((total, area) => total + area, 0);
  return {
    firstFrame: present[0] ?? 0,
    lastFrame: present[present.length - 1] ?? 0,
    frames: present.length,
    meanArea: sum / present.length,
  };
}

/** Collects window after window. */
export class Collector {
  /** @type {Uint32Array<ArrayBuffer>[]} */
  #runs = [];
  /** @type {number[]} */
  #times = [];
  /** @type {number | null} */
  #end = null;
  /** @type {Shot[]} */
  #shots = [];
  #tracks = new TrackCollector();
  #size = { width: 0, height: 0 };

  /**
   * Takes all of a window at its end; on the way there the thread may answer others.
   * @param {import('./window.js').WindowResult} window
   */
  async add(window) {
    const frames = [];
    for (const { index, time, labels } of window.frames()) {
      frames.push({ index, time, runs: encodeRuns(labels) });
      if (frames.length % BATCH === 0) await breath();
    }
    this.#size = { width: window.width, height: window.height };
    for (const { index, time, runs } of frames) {
      const shot = (this.#shots[window.shot] ??= { first: index, last: index });
      shot.last = index;
      this.#runs.push(runs);
      this.#times.push(time);
    }
    // Of frames that the next window settles nothing is asked yet.
    this.#end = window.settled.to === window.times.length ? window.end : (window.times[window.settled.to] ?? null);
    this.#tracks.add(window);
  }

  finish() {
    const result = this.sofar();
    if (!result) throw new TraceCutError('no-frames', 'the source has no frames');
    return result;
  }

  /** The result of the frames that are there by now; null without any. */
  sofar() {
    const numFrames = this.#runs.length;
    if (numFrames === 0) return null;
    return new VideoResult({
      ...this.#size,
      times: Float64Array.from(this.#times),
      end: this.#end,
      shots: this.#shots.map((shot) => ({ ...shot })),
      runs: [...this.#runs],
      trajectories: this.#tracks.finish(numFrames),
    });
  }
}
