/** Dialogs that are fetched when they are first opened. @module */

import { say } from '../language.js';

/**
 * What opens a dialog. Where it cannot be fetched the page says so, and the next call tries again. Its module is looked for
 * first: a browser does not fetch a module again that it could not import.
 *
 * @param {import('../store.js').Store} store
 * @param {URL} module of the dialog
 * @param {() => Promise<{open: () => void}>} importDialog
 * @returns {() => Promise<void>}
 */
export function onDemand(store, module, importDialog) {
  /** @type {Promise<{open: () => void}> | undefined} */
  let fetched;
  return async () => {
    try {
      fetched ??= fetch(module).then(importDialog);
      await fetched;
    } catch {
      fetched = undefined;
      store.set({ notice: say('The network does not answer, so this could not be opened. Please try again.') });
    }
    (await fetched)?.open();
  };
}
