/** Dialogs that are fetched when they are first opened. @module */

import { say } from '../language.js';

/**
 * What opens a dialog. Where it cannot be fetched the page says so, and the next call tries again.
 *
 * @param {import('../store.js').Store} store
 * @param {() => Promise<{open: () => void}>} fetchDialog
 * @returns {() => Promise<void>}
 */
export function onDemand(store, fetchDialog) {
  /** @type {Promise<{open: () => void}> | undefined} */
  let fetched;
  return async () => {
    try {
      fetched ??= fetchDialog();
      await fetched;
    } catch {
      fetched = undefined;
      store.set({ notice: say('The network does not answer, so this could not be opened. Please try again.') });
    }
    (await fetched)?.open();
  };
}
