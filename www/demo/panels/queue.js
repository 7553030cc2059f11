/** Gives clips that were opened together to the queue, which is fetched then. @module */

import { onDemand } from './on-demand.js';

/** @param {Pick<import('./panels.js').Page, 'store' | 'library'>} page */
export function queuePanel({ store, library }) {
  /** @type {File[]} Others may be opened while it is fetched. */
  const waiting = [];
  const open = onDemand(store, async () => {
    const queue = new (await import('./queue-list.js')).Queue(store, library);
    return { open: () => queue.add(waiting.splice(0)) };
  });
  store.watch(['queued'], ({ queued }) => {
    waiting.push(...queued);
    if (waiting.length > 0) void open();
  });
}
