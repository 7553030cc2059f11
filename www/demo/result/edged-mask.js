/** A mask with its edges as they are wanted. @module */

import { adjustMask } from '../../dist/edit.js';
import { edgesOf } from './edges.js';

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
   * @param {import('./edges.js').EdgeChoice} choice
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
