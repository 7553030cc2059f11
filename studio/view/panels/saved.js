/** What was kept of work on clips, and a run that was cut off, are offered; what the user opens is kept from then on. @module */

import { stored } from '../storage.js';

/** @param {Pick<import('../page.js').Page, 'store' | 'app'>} page */
export function savedPanel(page) {
  /** @type {Promise<import('./works.js').Works> | undefined} */
  let fetched;
  const works = () => (fetched ??= import('./keeping.js').then(({ keepWork }) => keepWork(page)));
  page.store.watch(['source'], ({ source }) => {
    if (source?.files) works().catch(() => (fetched = undefined));
  });
  stored().then(async (all) => all.length > 0 && (await works()).offer());
}
