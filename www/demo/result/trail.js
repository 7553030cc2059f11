/** Objects cut out on screen: masks with their edges, and the trail of earlier frames. @module */

import { adjustMask, cutOut, trailFrames } from '../library.js';
import { edgesOf } from '../saved/look.js';
import { shotsOf } from './export.js';

/** @typedef {import('../saved/look.js').EdgeChoice} EdgeChoice */
/** @typedef {import('../library.js').Cutout} Cutout */
/** @typedef {Readonly<import('../store.js').State>} State */

/** The mask on screen with its edges; made again only when something of it is another. */
export class EdgedMask {
  constructor() {
    this.key = '';
    /** @type {Uint8Array | null} */
    this.from = null;
    /** @type {ReturnType<typeof adjustMask> | null} */
    this.made = null;
  }

  /**
   * @param {Uint8Array} labels
   * @param {{width: number, height: number}} size
   * @param {EdgeChoice} choice
   * @param {ReadonlySet<number>} hidden objects that are not kept
   */
  of(labels, { width, height }, choice, hidden) {
    const key = [choice.smallest, choice.grow, choice.feather, ...hidden].join();
    if (this.made && this.from === labels && this.key === key) return this.made;
    const objects = (/** @type {number} */ label) => label > 0 && !hidden.has(label);
    this.made = adjustMask({ labels, width, height }, { objects, ...edgesOf(choice, { width, height }) });
    Object.assign(this, { key, from: labels });
    return this.made;
  }
}

/** Of how many frames objects are kept: as many as the longest trail has, and some more. */
const MOST = 96;

export class TrailCutouts {
  constructor() {
    /** @type {Map<number, {cutout: Cutout | null, smooth: boolean}>} By frame, in the order in which they were made. */
    this.made = new Map();
    /** @type {unknown[]} What they were made of. */
    this.from = [];
    this.edged = new EdgedMask();
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {State} state
   * @param {number} frame
   * @returns {{cutout: Cutout | null, opacity: number}[]} without those whose frames are still on their way
   */
  of(ctx, state, frame) {
    const { ground, film, found, picture, edges, hidden, smoothed } = state;
    const from = [found?.points, picture.images, edges, hidden, smoothed?.whole];
    if (from.some((one, k) => one !== this.from[k])) this.made.clear();
    this.from = from;
    return trailFrames(frame, ground.trail, shotsOf(film, film.numFrames)).flatMap(({ t, opacity }) => {
      const cutout = this.cut(ctx, state, t);
      return cutout ? [{ cutout, opacity }] : [];
    });
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {State} state
   * @param {number} t
   * @returns {Cutout | null}
   */
  cut(ctx, { found, picture, edges, hidden, smoothed }, t) {
    const known = this.made.get(t);
    const smooth = smoothed && !known?.smooth ? smoothed.labels(t) : null;
    if (known && !smooth) return known.cutout;
    const points = found?.points;
    const labels = smooth ?? points?.mask(t);
    const image = picture.images.get(t, 0);
    if (!points || !labels || !image) return null;
    const cutout = cutOut(ctx, image, this.edged.of(labels, points.result, edges, hidden));
    this.made.delete(t);
    this.made.set(t, { cutout, smooth: smooth !== null });
    if (this.made.size > MOST) this.made.delete(/** @type {number} */ (this.made.keys().next().value));
    return cutout;
  }
}
