/**
 * Work is not lost: it is kept in the browser whenever it has changed, offered again after a reload, and nobody leaves
 * it by mistake.
 * @module
 */

import { byId } from '../dom.js';
import { Packer, isWork, reopened } from '../saved/work.js';
import { forget, keep, kept } from '../saved/storage.js';

/** Changes within this time are kept together, in milliseconds. */
const WAIT_MS = 700;

/** @param {Pick<import('./panels.js').Page, 'store' | 'app' | 'library'>} page */
export function savedPanel({ store, app, library }) {
  const packer = new Packer(library);
  let timer = 0;
  let pending = false;
  /** @type {Promise<void>} One after the other. */
  let keeping = Promise.resolve();
  const keepNow = async () => {
    const { state } = store;
    if (!isWork(state)) return;
    try {
      await keep(await packer.pack(state));
      document.body.dataset.kept = String(Date.now());
    } catch {
      // No storage, or too little: leaving is asked about.
      return;
    }
    pending = false;
  };
  store.watch(['phase', 'found'], (state) => {
    if (!isWork(state)) return;
    pending = true;
    byId('saved').hidden = true;
    clearTimeout(timer);
    timer = window.setTimeout(() => (keeping = keeping.then(keepNow)), WAIT_MS);
  });
  addEventListener('beforeunload', (event) => {
    const { phase, job, source } = store.state;
    const underWay = phase === 'running' && (job?.settled ?? 0) > 0 && source?.files;
    if (pending || underWay) event.preventDefault();
  });
  offer(store, app, library);
}

/**
 * Offers what was kept when the page was opened.
 *
 * @param {import('../store.js').Store} store
 * @param {import('../app.js').App} app
 * @param {import('../run/job.js').Library} library
 */
async function offer(store, app, library) {
  const saved = await kept();
  // Something else may have been opened meanwhile.
  if (!saved || isWork(store.state)) return;
  const bar = byId('saved');
  byId('saved-text').textContent = `Your work on ${saved.name} was kept.`;
  bar.hidden = false;
  byId('saved-open').addEventListener('click', async () => {
    bar.hidden = true;
    await app.openWork(saved.name, () => reopened(saved, library));
  });
  byId('saved-forget').addEventListener('click', async () => {
    bar.hidden = true;
    await forget();
  });
}
