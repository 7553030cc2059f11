// Where nothing was found: says where the run looked, and offers what to try next; each button starts it.

import { searchReport } from '../../model/library.js';
import { TOUCH, byId, h } from '../dom.js';
import { triesOf, whereWords } from '../../model/tries.js';
import type { Page } from '../page.js';

export function showNothing({ store, app }: Pick<Page, 'store' | 'app'>) {
  const { state } = store;
  const result = state.found?.points?.result;
  if (!result) return;
  const report = searchReport(result);
  byId('nothing-where').textContent = whereWords(report);
  const tries = triesOf(state, report).map(({ id, label, patch }) =>
    h('button', { type: 'button', 'data-try': id, click: () => (store.set(patch), app.again()) }, label),
  );
  const adds = TOUCH ? 'Tap the object to add it' : 'Click the object to add it';
  tries.push(h('button', { type: 'button', 'data-try': 'add', click: addByClick }, adds));
  byId('nothing-tries').replaceChildren(...tries);
}

/** Goes to the tool with which a click adds a thing. */
function addByClick() {
  document.querySelector<HTMLInputElement>('#correct-tools [value="add"]')?.click();
  byId('correct-open').click();
}
