/** The gallery: clips with their masks ready. All that it needs is fetched when it is looked at. @module */

import { byId } from '../dom.js';

/** @param {import('./panels.js').Page} page */
export function galleryPanel(page) {
  const box = /** @type {HTMLDetailsElement} */ (byId('gallery'));
  box.addEventListener('toggle', async () => {
    if (!box.open) return;
    const { showGallery } = await import('./gallery-clips.js');
    await showGallery(page);
  });
}
