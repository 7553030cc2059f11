/** Opens what corrects a result, which is fetched then. @module */

import { byId } from '../dom.js';
import { onDemand } from './on-demand.js';

/** @param {Pick<import('./panels.js').Page, 'store' | 'viewer' | 'keys'>} page */
export function correctPanel(page) {
  const open = onDemand(page.store, async () => new (await import('./correction.js')).Correction(page));
  byId('correct-open').addEventListener('click', open);
  page.keys.on('m', () => void open());
}
