/** Opening, starting and cancelling, by buttons and files; how far a run is. @module */

import { TOUCH, byId, connectDialog } from '../dom.js';

/** @param {Pick<import('../page.js').Page, 'app' | 'store' | 'keys'>} page */
export function runPanel({ app, store, keys }) {
  /** @type {[ids: string[], act: () => unknown][]} */
  const buttons = [
    [['sample', 'error-sample'], () => app.openSample()],
    [['again', 'pending-run'], () => app.again()],
    [['restore'], () => app.restore()],
    [['resume'], () => app.resume()],
    [['cancel'], () => app.cancel()],
  ];
  for (const [ids, act] of buttons) for (const id of ids) byId(id).addEventListener('click', act);
  keys.on('Escape', () => app.cancel());
  const isKept = () => store.state.before !== null;
  keys.on('Ctrl+z', () => app.restore(), isKept);
  store.watch(['before'], () => (byId('restore').hidden = !isKept()));
  store.watch(['phase'], ({ phase, job, live }) => {
    if (phase !== 'done' || !job?.lost) return;
    // It is said above the panel, which may be elsewhere.
    byId('restore').scrollIntoView({ block: 'nearest' });
    if (!live.includes(job.lost)) store.set({ live: `${live}. ${job.lost}` });
  });
  app.asks = connectQuestion();
  /** @type {Open} */
  const open = (files) => {
    const all = [...(files ?? [])];
    if (all.length > 0) app.openFiles(all);
  };
  connectPicker(open, keys);
  connectDrop(open);
  addEventListener('paste', (event) => open(event.clipboardData?.files));
}

/** @returns {() => Promise<boolean>} asks whether to run again, though corrections are not part of that */
function connectQuestion() {
  const dialog = /** @type {HTMLDialogElement} */ (byId('ask'));
  connectDialog(dialog);
  return () => {
    dialog.returnValue = '';
    dialog.showModal();
    return new Promise((answer) => (dialog.onclose = () => answer(dialog.returnValue === 'yes')));
  };
}

/** @typedef {(files: Iterable<File> | null | undefined) => void} Open */

/**
 * @param {Open} open
 * @param {import('../keyboard.js').Keys} keys
 */
function connectPicker(open, keys) {
  const pick = connectInput('file', open);
  for (const id of ['open', 'error-open']) byId(id).addEventListener('click', pick);
  keys.on('o', pick);
  // Computers ignore `capture` and show the files again.
  byId('camera-open').hidden = !TOUCH;
  byId('camera-open').addEventListener('click', connectInput('camera', open));
}

/**
 * @param {string} id of a file input
 * @param {Open} open
 * @returns {() => void} shows its files, or the camera
 */
function connectInput(id, open) {
  const input = /** @type {HTMLInputElement} */ (byId(id));
  input.addEventListener('change', () => {
    const files = [...(input.files ?? [])];
    // The same file may be picked again.
    input.value = '';
    open(files);
  });
  return () => input.click();
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
