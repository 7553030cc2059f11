// Enlarges the masks of the next frames in workers while the present one is painted.

import { countParallelEnlargements } from './enlarge.js';
import type { MaskAtSize } from './at-size.js';

/** A frame's picture and its mask, which is still being computed; `close` frees the picture. */
export type PendingFrame<P> = { picture: P; mask: Promise<MaskAtSize>; close?: () => void };

/**
 * Yields frames with their masks, in order. As many frames are prepared ahead as are enlarged at once; no frame is read
 * beyond the last.
 * @param count number of frames
 * @param take copies what it needs of an item: the next item may be the same object
 * @returns a picture is valid until the next one is requested
 */
export async function* prefetch<I, P>(
  items: Iterable<I> | AsyncIterable<I>,
  count: number,
  take: (item: I, t: number) => Promise<PendingFrame<P>>,
): AsyncGenerator<{ picture: P; mask: MaskAtSize }, void, undefined> {
  const waiting: PendingFrame<P>[] = [];
  const maxWaiting = countParallelEnlargements();
  async function* first() {
    const [{ picture, mask }] = waiting as [PendingFrame<P>];
    yield { picture, mask: await mask };
    waiting.shift()?.close?.();
  }
  try {
    let t = 0;
    for await (const item of items) {
      const pending = await take(item, t);
      // Its error is thrown when its turn comes.
      pending.mask.catch(() => {});
      waiting.push(pending);
      t += 1;
      if (t === count) break;
      if (waiting.length > maxWaiting) yield* first();
    }
    while (waiting.length > 0) yield* first();
  } finally {
    for (const { close } of waiting) close?.();
  }
}
