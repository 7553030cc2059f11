/**
 * A result seen frame by frame and object by object: which trajectories are alive in a frame and where, masks, shares
 * of objects, spacing. Objects are numbered as in the masks, 0 for the background; without masks each cluster is taken
 * for an object.
 * @module
 */

/**
 * The part of a result that drawing needs. `trajectories` holds points of trajectory `i` at
 * `offset[i]..offset[i + 1]`, the first of them in frame `startFrame[i]`, in input pixels.
 *
 * @typedef {object} Result
 * @property {number} width
 * @property {number} height
 * @property {number} numFrames
 * @property {{count: number, startFrame: Uint32Array, offset: Uint32Array, x: Float32Array, y: Float32Array}}
 *   trajectories
 * @property {{count: number, label: Uint32Array, object: Uint8Array | null}} clusters each with its object
 * @property {readonly {label: number}[] | null} objects null without masks
 * @property {{ofPoints: Float32Array, inContext: Float32Array, foreground: Uint8Array} | null} saliency null without
 *   frames
 * @property {{count: Uint32Array, ofPoint: Int32Array} | null} components null without frames; -1 for points that are
 *   in none
 * @property {(t: number) => Uint8Array} labels
 * @property {{dimensions: number, eigenvalues: Float64Array, vectors: Float32Array}} embedding
 * @property {(t: number) => {i: Uint32Array, j: Uint32Array, d: Float32Array}} edges
 * @property {() => string | Promise<string>} toTracksDat
 */

import { sceneMotion } from '../library.js';
import { Presence } from './presence.js';

/** @typedef {{id: Uint32Array, x: Float32Array, y: Float32Array}} FramePoints Trajectories alive in a frame. */

/** Masks that are kept; those of a long clip lie elsewhere in a small form. */
const MASKS = 64;

/** Indexes a result by frame; answers are cached, so playing costs nothing after the first round. */
export class Points {
  /**
   * @param {Result} result
   * @param {Presence | null} [presence] where that is known already
   */
  constructor(result, presence = null) {
    this.result = result;
    /** @type {Map<number, FramePoints>} */
    this.cache = new Map();
    /** @type {Map<number, number>} */
    this.spacings = new Map();
    /** @type {Map<number, Uint8Array>} */
    this.masks = new Map();
    const { clusters, objects } = result;
    this.hasMasks = objects !== null;
    /** One more than the highest label, or the number of clusters. */
    this.count = objects ? Math.max(0, ...objects.map(({ label }) => label)) + 1 : clusters.count;
    /** The object that each trajectory belongs to. */
    const { object } = clusters;
    this.object = object ? Uint32Array.from(clusters.label, (cluster) => object[cluster]) : clusters.label;
    const { numFrames, trajectories } = result;
    /** How the scene moves in the picture. */
    this.scene = sceneMotion({ numFrames, trajectories: { ...trajectories, label: this.object } });
    this.presence = presence ?? new Presence(result);
    for (let t = this.presence.frames.length; t < result.numFrames; t++) {
      const mask = this.mask(t);
      if (mask) this.presence.addMask(mask);
      else this.presence.addPoints(this.at(t), this.object);
    }
  }

  /**
   * @param {number} frame
   * @returns {Uint8Array | null} the object of each pixel; null without masks, and of frames that are not settled yet
   */
  mask(frame) {
    if (!this.hasMasks || frame >= this.result.numFrames) return null;
    const mask = this.masks.get(frame) ?? this.result.labels(frame);
    this.masks.delete(frame);
    this.masks.set(frame, mask);
    if (this.masks.size > MASKS) this.masks.delete(/** @type {number} */ (this.masks.keys().next().value));
    return mask;
  }

  /**
   * @param {number} frame
   * @param {number} px input pixels
   * @param {number} py
   * @returns {number} the object there; -1 outside of the frame, and without masks
   */
  objectAt(frame, px, py) {
    const { width, height } = this.result;
    const [x, y] = [Math.round(px), Math.round(py)];
    const inside = x >= 0 && y >= 0 && x < width && y < height;
    return inside ? (this.mask(frame)?.[y * width + x] ?? -1) : -1;
  }

  /**
   * @param {number} object
   * @returns {number} how many clusters make it up
   */
  clustersOf(object) {
    const { clusters } = this.result;
    return clusters.object
      ? clusters.object.reduce((n, label) => n + Number(label === object), 0)
      : Number(object < clusters.count);
  }

  /**
   * @param {number} frame
   * @returns {FramePoints}
   */
  at(frame) {
    const known = this.cache.get(frame);
    if (known) return known;
    const { count, startFrame, offset, x, y } = this.result.trajectories;
    const ids = [];
    for (let i = 0; i < count; i++) {
      const age = frame - startFrame[i];
      if (age >= 0 && age < offset[i + 1] - offset[i]) ids.push(i);
    }
    const id = Uint32Array.from(ids);
    const at = (/** @type {number} */ i) => offset[i] + frame - startFrame[i];
    const points = { id, x: Float32Array.from(id, (i) => x[at(i)]), y: Float32Array.from(id, (i) => y[at(i)]) };
    this.cache.set(frame, points);
    return points;
  }

  /**
   * @param {number} trajectory
   * @param {number} frame
   * @returns {number} index of its point in `x` and `y`, or -1 where it is not alive
   */
  index(trajectory, frame) {
    const { startFrame, offset } = this.result.trajectories;
    const age = frame - startFrame[trajectory];
    return age >= 0 && age < offset[trajectory + 1] - offset[trajectory] ? offset[trajectory] + age : -1;
  }

  /**
   * The trajectory nearest to a place.
   *
   * @param {number} frame
   * @param {number} px input pixels
   * @param {number} py
   * @param {number} reach input pixels
   * @param {(object: number) => boolean} visible
   * @returns {number} trajectory, or -1
   */
  nearest(frame, px, py, reach, visible) {
    const { id, x, y } = this.at(frame);
    let best = -1;
    let bestSq = reach * reach;
    for (let k = 0; k < id.length; k++) {
      const sq = (x[k] - px) ** 2 + (y[k] - py) ** 2;
      if (sq < bestSq && visible(this.object[id[k]])) {
        best = id[k];
        bestSq = sq;
      }
    }
    return best;
  }

  /**
   * @param {number} frame
   * @returns {number} typical distance of neighbouring points in input pixels
   */
  spacing(frame) {
    const known = this.spacings.get(frame) ?? this.measureSpacing(frame);
    this.spacings.set(frame, known);
    return known;
  }

  /** @param {number} frame */
  measureSpacing(frame) {
    const { x } = this.at(frame);
    if (x.length < 2) return 8;
    const { i, j } = this.result.edges(frame);
    const lengths = [];
    for (let e = 0; e < i.length; e++) {
      const a = this.index(i[e], frame);
      const b = this.index(j[e], frame);
      if (a >= 0 && b >= 0) lengths.push(this.distance(a, b));
    }
    return lengths.length > 0 ? quantile(lengths, 0.5) : Math.sqrt((this.result.width * this.result.height) / x.length);
  }

  /**
   * @param {number} a index into `x` and `y`
   * @param {number} b
   * @returns {number} input pixels
   */
  distance(a, b) {
    const { x, y } = this.result.trajectories;
    return Math.hypot(x[a] - x[b], y[a] - y[b]);
  }
}

/**
 * @param {Iterable<number>} values
 * @param {number} q in 0..1
 * @returns {number} 0 when there are none
 */
export function quantile(values, q) {
  const sorted = Float64Array.from(values).sort();
  return sorted.length === 0 ? 0 : sorted[Math.round(q * (sorted.length - 1))];
}
