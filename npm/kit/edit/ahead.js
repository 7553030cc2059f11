// Frames whose masks are enlarged in workers while the one before is painted.

import { enlargedAtOnce } from './enlarge.js';

/**
 * What was taken of a frame, and its mask, which is on its way; `close` lets go of what was taken.
 * @template P
 * @typedef {{picture: P, mask: Promise<import('./at-size.js').MaskAtSize>, close?: () => void}} Taken
 */

/**
 * Frames with their masks, in order. As many are taken ahead as are enlarged at once; no frame is read beyond the last.
 * @template P
 * @param {Iterable<unknown> | AsyncIterable<unknown>} items
 * @param {number} count frames that are wanted
 * @param {(item: any, t: number) => Promise<Taken<P>>} take copies what it needs of an item: the next one may be the same
 *   object
 * @returns {AsyncGenerator<{picture: P, mask: import('./at-size.js').MaskAtSize}, void, undefined>} a picture is there
 *   until the next is asked for
 */
export async function* ahead(items, count, take) {
  /** @type {Taken<P>[]} */
  const waiting = [];
  const most = enlargedAtOnce();
  async function* first() {
    const [{ picture, mask }] = /** @type {[Taken<P>]} */ (waiting);
    yield { picture, mask: await mask };
    waiting.shift()?.close?.();
  }
  try {
    let t = 0;
    for await (const item of items) {
      const taken = await take(item, t);
      // Heard of when its turn comes.
      taken.mask.catch(() => {});
      waiting.push(taken);
      t += 1;
      if (t === count) break;
      if (waiting.length > most) yield* first();
    }
    while (waiting.length > 0) yield* first();
  } finally {
    for (const { close } of waiting) close?.();
  }
}
