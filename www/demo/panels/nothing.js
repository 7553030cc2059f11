/** Where nothing was found: says where was looked, and offers what to try next; each button starts it. @module */

import { TOUCH, byId, h } from '../dom.js';
import { foundNothing, triesOf, whereWords } from '../result/nothing.js';
import { say } from '../language.js';

/** @param {Pick<import('./panels.js').Page, 'store' | 'app' | 'library'>} page */
export function nothingPanel({ store, app, library }) {
  store.watch(['phase', 'found', 'correcting'], (state) => {
    const nothing = foundNothing(state) && !state.correcting;
    byId('nothing').hidden = !nothing;
    const result = state.found?.points?.result;
    if (!nothing || !result) return;
    // Of many windows there are no clusters but the objects.
    const report = library.searchReport(state.found?.windows ? { ...result, clusters: undefined } : result);
    byId('nothing-where').textContent = whereWords(report);
    const tries = triesOf(state, report).map(({ id, label, patch }) =>
      h('button', { type: 'button', 'data-try': id, click: () => (store.set(patch), app.start()) }, label),
    );
    const adds = TOUCH ? say('Tap the object to add it') : say('Click the object to add it');
    tries.push(h('button', { type: 'button', 'data-try': 'add', click: addByClick }, adds));
    byId('nothing-tries').replaceChildren(...tries);
  });
}

/** Goes to the tool with which a click adds a thing. */
function addByClick() {
  /** @type {HTMLInputElement | null} */ (document.querySelector('#correct-tools [value="add"]'))?.click();
  byId('correct-open').click();
}
