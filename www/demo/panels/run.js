/** Opening, starting and cancelling: the buttons of the heading, files that are picked, dropped or pasted. @module */

import { byId } from '../dom.js';
import { areClips } from '../source.js';

/** @typedef {import('../app.js').App} App */

/** @param {Pick<import('./panels.js').Page, 'app' | 'store' | 'keys'>} page */
export function runPanel({ app, store, keys }) {
  /** @type {[ids: string[], act: () => unknown][]} */
  const buttons = [
    [['sample', 'error-sample'], () => app.openSample()],
    [['again', 'pending-run'], () => app.start()],
    [['resume'], () => app.resume()],
    [['cancel'], () => app.cancel()],
  ];
  for (const [ids, act] of buttons) for (const id of ids) byId(id).addEventListener('click', act);
  keys.on('Escape', () => app.cancel());
  keys.on('r', () => ['done', 'stopped'].includes(store.state.phase) && app.start());
  const open = (/** @type {Iterable<File> | null | undefined} */ files) => openAll(app, store, files);
  connectPicker(open, keys);
  connectDrop(open);
  addEventListener('paste', (event) => open(event.clipboardData?.files));
}

/** @typedef {(files: Iterable<File> | null | undefined) => void} Open */

/**
 * @param {App} app
 * @param {import('../store.js').Store} store
 * @param {Iterable<File> | null | undefined} files several videos are queued
 */
function openAll(app, store, files) {
  const all = [...(files ?? [])];
  if (areClips(all)) store.set({ queued: all });
  else if (all.length > 0) app.openFiles(all);
}

/**
 * @param {Open} open
 * @param {import('../keyboard.js').Keys} keys
 */
function connectPicker(open, keys) {
  const picker = /** @type {HTMLInputElement} */ (byId('file'));
  picker.addEventListener('change', () => {
    const files = [...(picker.files ?? [])];
    // The same file may be picked again.
    picker.value = '';
    open(files);
  });
  for (const id of ['open', 'error-open']) byId(id).addEventListener('click', () => picker.click());
  keys.on('o', () => picker.click());
}

/** @param {Open} open */
function connectDrop(open) {
  let depth = 0;
  const hover = (/** @type {number} */ by) => {
    depth = Math.max(0, depth + by);
    document.body.classList.toggle('is-dropping', depth > 0);
  };
  addEventListener('dragenter', () => hover(1));
  addEventListener('dragleave', () => hover(-1));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    hover(-depth);
    open(event.dataTransfer?.files);
  });
}
