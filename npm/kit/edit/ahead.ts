// Frames whose masks are enlarged in workers while the one before is painted.

import { enlargedAtOnce } from './enlarge.js';
import type { MaskAtSize } from './at-size.js';

/** What was taken of a frame, and its mask, which is on its way; `close` lets go of what was taken. */
export type Taken<P> = { picture: P; mask: Promise<MaskAtSize>; close?: () => void };

/**
 * Frames with their masks, in order. As many are taken ahead as are enlarged at once; no frame is read beyond the last.
 * @param count frames that are wanted
 * @param take copies what it needs of an item: the next one may be the same object
 * @returns a picture is there until the next is asked for
 */
export async function* ahead<I, P>(
  items: Iterable<I> | AsyncIterable<I>,
  count: number,
  take: (item: I, t: number) => Promise<Taken<P>>,
): AsyncGenerator<{ picture: P; mask: MaskAtSize }, void, undefined> {
  const waiting: Taken<P>[] = [];
  const most = enlargedAtOnce();
  async function* first() {
    const [{ picture, mask }] = waiting as [Taken<P>];
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
