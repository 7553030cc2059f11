/** The edges of masks as they are wanted. @module */

import { adjustMask } from '../../dist/index.js';

/**
 * The smallest piece that counts, in percent of the frame; how far objects grow, or shrink where it is negative, and how
 * soft their edges are, in pixels of the masks.
 *
 * @typedef {{smallest: number, grow: number, feather: number}} EdgeChoice
 */

/** Specks are nobody's wish. @type {EdgeChoice} */
export const DEFAULT_EDGES = { smallest: 0.02, grow: 0, feather: 0 };

/**
 * @param {EdgeChoice} choice
 * @param {{width: number, height: number}} size of the masks
 * @returns {import('../../dist/index.js').MaskEdges} as the package takes it
 */
export function edgesOf({ smallest, grow, feather }, { width, height }) {
  return { smallest: Math.ceil((smallest / 100) * width * height), grow, feather };
}

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
