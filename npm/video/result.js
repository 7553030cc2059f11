// The masks, shots and objects of a whole clip: `VideoResult`.

import { TraceCutError, illegal, wholeNumber } from '../check/errors.js';
import { objectList, tracksDat } from '../session/report.js';
import { areasOf, checkRuns, decodeRuns, encodeRuns, joinRuns, splitRuns } from '../session/runs.js';
import { opened, saved } from '../session/saved.js';
import { breath } from '../worker/pause.js';

/** @typedef {import('../session/runs.js').Runs} Runs */

/**
 * A stretch of frames without a cut, `first` and `last` included. Objects of different shots have different labels.
 * @typedef {{readonly first: number, readonly last: number}} Shot
 */

/**
 * Where a source was cut off or damaged: the number of frames before, and what is wrong.
 * @typedef {{readonly frames: number, readonly reason: string}} Truncated
 */

/**
 * @typedef {object} Collected
 * @property {number} width
 * @property {number} height
 * @property {Float64Array<ArrayBuffer>} times
 * @property {number | null} [end]
 * @property {readonly Shot[]} shots
 * @property {Runs[]} runs
 * @property {ClipTrajectories} trajectories
 * @property {Truncated | null} [truncated]
 */

/** Frames between two breaths. */
const BATCH = 8;

/** The masks, objects and trajectories of a whole clip; made by `collect`. Its masks lie run-length coded in memory. */
export class VideoResult {
  /** @param {Collected} collected */
  constructor(collected) {
    /** Width of the masks in pixels. @readonly */
    this.width = collected.width;
    /** Height of the masks in pixels. @readonly */
    this.height = collected.height;
    /** Number of frames. @readonly */
    this.numFrames = collected.times.length;
    /** The time of each frame, in seconds. @readonly */
    this.times = collected.times;
    /** When the last frame ends, in seconds; null where nothing says. @readonly */
    this.end = collected.end ?? null;
    /** Whether the source was cut off or damaged: masks are of the frames before. Null for a whole clip. @readonly */
    this.truncated = collected.truncated ?? null;
    /**
     * The shots of the clip, in order.
     * @type {readonly Shot[]}
     * @readonly
     */
    this.shots = collected.shots;
    /** Point trajectories over the whole clip, in pixels of the masks, each with its object. @readonly */
    this.trajectories = collected.trajectories;
    /** The masks as runs of equal labels, row by row: the label in the lowest 8 bits, the length above. @readonly */
    this.runs = collected.runs;
    /** The objects, by their labels. @readonly */
    this.objects = objectsOf(collected.runs);
  }

  /**
   * The mask of frame `t`: one byte for each pixel, row by row; 0 is the background.
   * @param {number} t
   * @returns {Uint8Array<ArrayBuffer>}
   */
  labels(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    return decodeRuns(/** @type {Runs} */ (this.runs[t]));
  }

  /**
   * All of it for `JSON.stringify`, compressed; `fromJSON` is the way back. `structuredClone` gives its data too, as a
   * plain object without methods, which `fromJSON` takes as well.
   * @returns {Record<string, unknown>}
   */
  toJSON() {
    const { objects: _, runs, ...rest } = this;
    return saved({ ...rest, runs: joinRuns(runs) });
  }

  /**
   * A result that was saved.
   * @param {string | object} json what `JSON.stringify` made, or that parsed, or what `structuredClone` gave
   * @returns {VideoResult} with code `data` where it is damaged, or another kind of result
   */
  static fromJSON(json) {
    const { runs: words, ...rest } = opened(json, ['times', 'shots', 'runs', 'trajectories']);
    /** @type {unknown[]} */
    const frames = words instanceof Uint32Array ? splitRuns(words, rest.times.length) : words;
    const size = rest.width * rest.height;
    const runs = Array.from(rest.times, (_, t) => checkRuns(`the mask of frame ${t}`, frames[t], size));
    return new VideoResult({ ...rest, runs });
  }

  /**
   * The trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
   * its label and length and, line by line, `x y frame`.
   * @returns {string}
   */
  toTracksDat() {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames });
  }
}

/**
 * @param {Runs[]} runs
 * @returns {import('../session/report.js').ObjectList}
 */
function objectsOf(runs) {
  /** @type {Map<number, Uint32Array<ArrayBuffer>>} */
  const areas = new Map();
  runs.forEach((frame, t) => {
    areasOf(frame).forEach((area, label) => {
      if (area === 0 || label === 0) return;
      if (!areas.has(label)) areas.set(label, new Uint32Array(runs.length));
      const own = /** @type {Uint32Array} */ (areas.get(label));
      own[t] = area;
    });
  });
  return objectList([...areas].map(([label, own]) => ({ label, areas: own })));
}

/** Collects window after window. */
export class Collector {
  /** @type {Runs[]} */
  #runs = [];
  /** @type {number[]} */
  #times = [];
  /** @type {number | null} */
  #end = null;
  /** @type {{first: number, last: number}[]} */
  #shots = [];
  #tracks = new TrackCollector();
  #size = { width: 0, height: 0 };
  /** @type {string | null | undefined} */
  #clip;

  /**
   * Takes all of a window at its end; on the way there the thread may answer others.
   * @param {import('./window.js').WindowResult} window
   */
  async add(window) {
    if (this.#clip === undefined) this.#clip = window.clip;
    if (window.clip !== this.#clip)
      throw illegal('data', 'clip', window.clip, `${this.#clip}: collect gives one, iterate over the windows`);
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

  /** @param {number} t */
  labels(t) {
    wholeNumber('param', 't', t, 0, this.#runs.length - 1);
    return decodeRuns(/** @type {Runs} */ (this.#runs[t]));
  }

  /** @param {TraceCutError | null} damage that the source ended with */
  finish(damage) {
    const frames = this.#runs.length;
    const result = this.sofar(damage && { frames, reason: damage.message });
    if (!result) throw new TraceCutError('no-frames', 'the source has no frames');
    return result;
  }

  /**
   * The result of the frames that are there by now; null without any.
   * @param {Truncated | null} [truncated]
   */
  sofar(truncated = null) {
    const numFrames = this.#runs.length;
    if (numFrames === 0) return null;
    return new VideoResult({
      ...this.#size,
      times: Float64Array.from(this.#times),
      end: this.#end,
      shots: this.#shots.map((shot) => ({ ...shot })),
      runs: [...this.#runs],
      trajectories: this.#tracks.finish(numFrames),
      truncated,
    });
  }
}

/**
 * Trajectories of a whole clip, shaped as `Result.trajectories`: the points of trajectory `i` are `offset[i]` to
 * `offset[i + 1]`, one for each of the consecutive frames from `startFrame[i]` on. `label[i]` is the object that most
 * of its points were on, 0 for the background.
 * @typedef {{readonly count: number, readonly startFrame: Uint32Array, readonly offset: Uint32Array, readonly x:
 *   Float32Array, readonly y: Float32Array, readonly label:
 *   Uint8Array}} ClipTrajectories
 */

/** @typedef {{start: number, x: number[], y: number[], votes: Map<number, number>}} Track */

/** Collects the trajectories of window after window. */
class TrackCollector {
  /** @type {Map<number, Track>} */
  #tracks = new Map();

  /** @param {import('./window.js').WindowResult} window */
  add({ trajectories, clusters, firstFrame }) {
    for (let i = 0; i < trajectories.count; i += 1) {
      const [begin, end] = [Number(trajectories.offset[i]), Number(trajectories.offset[i + 1])];
      const start = firstFrame + Number(trajectories.startFrame[i]);
      const track = this.#trackOf(Number(trajectories.id[i]), start);
      // The frames that an earlier window had are there already.
      const known = track.start + track.x.length - start;
      for (let p = begin + Math.max(0, known); p < end; p += 1) {
        track.x.push(Number(trajectories.x[p]));
        track.y.push(Number(trajectories.y[p]));
      }
      const label = Number(clusters.object?.[Number(clusters.label[i])] ?? 0);
      track.votes.set(label, (track.votes.get(label) ?? 0) + end - begin);
    }
  }

  /**
   * @param {number} id
   * @param {number} start
   */
  #trackOf(id, start) {
    let track = this.#tracks.get(id);
    if (!track) this.#tracks.set(id, (track = { start, x: [], y: [], votes: new Map() }));
    return track;
  }

  /**
   * @param {number} numFrames what lies beyond is left out
   * @returns {ClipTrajectories} in the order of their first frames
   */
  finish(numFrames) {
    const tracks = [...this.#tracks.values()]
      .filter(({ start }) => start < numFrames)
      .map((track) => ({
        ...track,
        x: track.x.slice(0, numFrames - track.start),
        y: track.y.slice(0, numFrames - track.start),
      }))
      .sort((a, b) => a.start - b.start);
    const offset = new Uint32Array(tracks.length + 1);
    tracks.forEach((track, i) => (offset[i + 1] = Number(offset[i]) + track.x.length));
    const points = Number(offset[tracks.length]);
    const joined = {
      count: tracks.length,
      startFrame: Uint32Array.from(tracks, ({ start }) => start),
      offset,
      x: new Float32Array(points),
      y: new Float32Array(points),
      label: Uint8Array.from(tracks, ({ votes }) => majority(votes)),
    };
    tracks.forEach((track, i) => {
      joined.x.set(track.x, offset[i]);
      joined.y.set(track.y, offset[i]);
    });
    return joined;
  }
}

/**
 * The label with most votes, the lowest of equals.
 * @param {Map<number, number>} votes
 */
function majority(votes) {
  let best = 0;
  let most = -1;
  for (const [label, count] of votes) {
    if (count > most || (count === most && label < best)) [best, most] = [label, count];
  }
  return best;
}
