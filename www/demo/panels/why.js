/** Opens what says why a pixel has its label, which is fetched then. @module */

import { byId } from '../dom.js';
import { onDemand } from './on-demand.js';

/** @param {Pick<import('./panels.js').Page, 'store' | 'viewer'>} page */
export function whyPanel(page) {
  const open = onDemand(page.store, async () => new (await import('./why-panel.js')).WhyPanel(page));
  byId('why-open').addEventListener('click', open);
  page.store.watch(['found', 'phase'], ({ found, phase }) => {
    byId('why-open').hidden = phase !== 'done' || !found?.answers.explain;
  });
}
