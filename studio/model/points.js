/** The masks of a result, frame by frame, and where its objects are. @module */

import { sceneMotion } from './library.js';
import { Presence } from './presence.js';

/**
 * A result, as the page looks at it. `trajectories` holds points of trajectory `i` at `offset[i]..offset[i + 1]`, the
 * first of them in frame `startFrame[i]`, in pixels of the masks, and the object of each as its `label`.
 *
 * @typedef {object} Result
 * @property {number} width
 * @property {number} height
 * @property {number} numFrames
 * @property {{count: number, startFrame: Uint32Array, offset: Uint32Array, x: Float32Array, y: Float32Array, label:
 *   ArrayLike<number>}} trajectories
 * @property {{count: number, label: ArrayLike<number>}} [clusters] of a clip that is one window
 * @property {readonly {label: number}[]} objects
 * @property {(t: number) => Uint8Array} labels
 * @property {() => string | Promise<string>} toTracksDat
 */

/** Masks that are kept; those of a long clip lie elsewhere in a small form. */
const MASKS = 64;

/** Answers are kept, so playing costs nothing after the first round. */
export class Points {
  /**
   * @param {Result} result
   * @param {Presence | null} [presence] where that is known already
   */
  constructor(result, presence = null) {
    this.result = result;
    /** @type {Map<number, Uint8Array>} */
    this.masks = new Map();
    /** One more than the highest label. */
    this.count = Math.max(0, ...result.objects.map(({ label }) => label)) + 1;
    /** How the scene moves in the picture. */
    this.scene = sceneMotion(result);
    this.presence = presence ?? new Presence(result);
    for (let t = this.presence.frames.length; t < result.numFrames; t++) this.presence.addMask(result.labels(t));
  }

  /**
   * @param {number} frame
   * @returns {Uint8Array | null} the object of each pixel; null of frames that are not settled yet
   */
  mask(frame) {
    if (frame >= this.result.numFrames) return null;
    const mask = this.masks.get(frame) ?? this.result.labels(frame);
    this.masks.delete(frame);
    this.masks.set(frame, mask);
    if (this.masks.size > MASKS) this.masks.delete(/** @type {number} */ (this.masks.keys().next().value));
    return mask;
  }

  /**
   * @param {number} frame
   * @param {number} px pixels of the masks
   * @param {number} py
   * @returns {number} the object there; -1 outside of the frame
   */
  objectAt(frame, px, py) {
    const { width, height } = this.result;
    const [x, y] = [Math.round(px), Math.round(py)];
    const inside = x >= 0 && y >= 0 && x < width && y < height;
    return inside ? (this.mask(frame)?.[y * width + x] ?? -1) : -1;
  }
}
