/** Saving results: the dialog is fetched when it is first opened. @module */

import { byId } from '../dom.js';
import { onDemand } from './on-demand.js';

/** @param {Pick<import('./panels.js').Page, 'store' | 'library' | 'selection' | 'keys' | 'viewer'>} page */
export function exportPanel(page) {
  const open = onDemand(page.store, async () => new (await import('./export-dialog.js')).ExportDialog(page));
  byId('export-open').addEventListener('click', open);
  page.keys.on('e', open);
}
