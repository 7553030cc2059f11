/** The trail on screen: objects of earlier frames, cut out once and kept as long as they look the same. @module */

import { cutOut, trailFrames } from '../../dist/draw.js';
import { EdgedMask } from './edged-mask.js';
import { shotsOf } from './export.js';

/** @typedef {import('../../dist/draw.js').Cutout} Cutout */
/** @typedef {Readonly<import('../store.js').State>} State */

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
