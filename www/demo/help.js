/** The dialog that lists the keys. @module */

import { byId, h } from './dom.js';

/** @type {[keys: string[], what: string][]} */
const KEYS = [
  [['Space'], 'play or pause'],
  [['←', '→'], 'one frame back or forward'],
  [['Home', 'End'], 'first or last frame'],
  [['V'], 'overlay, side by side, slider'],
  [['1', '…', '9'], 'layers, by their numbers'],
  [['S', 'F', 'C'], 'saliency, foreground, components'],
  [['O'], 'open a file'],
  [['M'], 'correct the result'],
  [['Ctrl', 'Z'], 'undo a correction'],
  [['E'], 'export'],
  [['R'], 'run again'],
  [['Esc'], 'cancel a run, close a dialog'],
  [['Tab'], 'next control'],
  [['?'], 'this list'],
];

/** Fills the dialog and connects its buttons. */
export function connectHelp() {
  const entries = KEYS.flatMap(([keys, what]) => [h('dt', {}, ...keys.flatMap((key) => [h('kbd', {}, key), ' '])), h('dd', {}, what)]);
  byId('help-keys').replaceChildren(...entries);
  byId('help-open').addEventListener('click', openHelp);
  connectDialog(helpDialog());
  byId('help-close').addEventListener('click', () => helpDialog().close());
}

export function openHelp() {
  if (!helpDialog().open) helpDialog().showModal();
}

/** @returns {HTMLDialogElement} */
function helpDialog() {
  return /** @type {HTMLDialogElement} */ (byId('help'));
}

/**
 * A click beside a dialog closes it.
 *
 * @param {HTMLDialogElement} dialog
 */
export function connectDialog(dialog) {
  dialog.addEventListener('click', (event) => {
    if (event.target !== dialog) return;
    const { left, right, top, bottom } = dialog.getBoundingClientRect();
    const inside = event.clientX >= left && event.clientX <= right && event.clientY >= top && event.clientY <= bottom;
    if (!inside) dialog.close();
  });
}
