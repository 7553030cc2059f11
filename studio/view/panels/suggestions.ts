// Shows what a run without objects tracked, and buttons with suggestions.

import { searchReport } from '../../model/library.js';
import { TOUCH, byId, h } from '../dom.js';
import { suggestChanges, describeSearch } from '../../model/suggestions.js';
import type { Page } from '../page.js';

export function showSuggestions({ store, app }: Pick<Page, 'store' | 'app'>) {
  const { state } = store;
  const result = state.analysis?.segmentation.result;
  if (!result) return;
  const report = searchReport(result);
  byId('suggestions-report').textContent = describeSearch(report);
  const buttons = suggestChanges(state, report).map(({ id, label, patch }) =>
    h('button', { type: 'button', 'data-suggestion': id, click: () => (store.set(patch), app.rerun()) }, label),
  );
  const adds = TOUCH ? 'Tap the object to add it' : 'Click the object to add it';
  buttons.push(h('button', { type: 'button', 'data-suggestion': 'add', click: addByClick }, adds));
  byId('suggestions-list').replaceChildren(...buttons);
}

/** Opens the tool that adds an object by a click. */
function addByClick() {
  document.querySelector<HTMLInputElement>('#correct-tools [value="add"]')?.click();
  byId('correct-open').click();
}
