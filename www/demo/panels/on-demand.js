/** Dialogs that are fetched when they are first opened. @module */

import { say } from '../language.js';

/** What is fetched to see whether the network answers; the service worker has it too. */
const PROBE = './favicon.svg';

/**
 * What opens a dialog. Where the network does not answer the page says so, and the next call tries again. That is seen
 * before the dialog is imported: some browsers never fetch a module again that they could not import.
 *
 * @param {import('../store.js').Store} store
 * @param {() => Promise<{open: () => void}>} importDialog
 * @returns {() => Promise<void>}
 */
export function onDemand(store, importDialog) {
  /** @type {Promise<{open: () => void}> | undefined} */
  let fetched;
  return async () => {
    try {
      fetched ??= fetch(PROBE, { cache: 'no-store' }).then(importDialog);
      await fetched;
    } catch {
      fetched = undefined;
      store.set({ notice: say('The network does not answer, so this could not be opened. Please try again.') });
    }
    (await fetched)?.open();
  };
}
