/**
 * Work on clips is kept in the browser as it goes; the last is offered when the page opens, all are in a list, to open
 * or to delete.
 * @module
 */

import { h, byId, connectDialog } from '../dom.js';
import { SavedJob } from '../run/clip-job.js';
import { Packer, isWork, reopened } from '../saved/work.js';
import { keep, bytesOf, forget, kept, stored } from '../saved/storage.js';
import { bytes } from '../words.js';
import { say, shownLanguage } from '../language.js';

/** @typedef {import('../saved/storage.js').Saved} Saved */

/** Changes within this time are kept together, in milliseconds. */
const WAIT_MS = 700;

/** A run that takes no longer need not be remembered, in milliseconds. */
const LONG_MS = 1000;

/** @param {Pick<import('../page.js').Page, 'store' | 'app'>} page */
export function savedPanel({ store, app }) {
  const packer = new Packer();
  const works = worksList({ store, app });
  const names = new Names(() => works.takeOpened());
  let timer = 0;
  /** Of all changes, how many there were; and whether the last is still to be kept. */
  let changes = 0;
  let pending = false;
  const isPending = (/** @type {boolean} */ now) => {
    pending = now;
    document.body.toggleAttribute('data-unkept', now);
  };
  /** @type {Promise<void>} One after the other. */
  let keeping = Promise.resolve();
  const keepNow = async () => {
    const { state } = store;
    const upTo = changes;
    if (!isWork(state)) return;
    try {
      await keep(await packer.pack(state, names.of(state)));
      works.update();
    } catch {
      // No storage, or too little: leaving is asked about.
      return;
    }
    document.body.dataset.kept = String(Date.now());
    // What changed while it was packed is kept by the next.
    if (upTo === changes) isPending(false);
  };
  store.watch(['phase', 'found', 'edges', 'hidden', 'ground'], (state) => {
    if (!isWork(state)) return;
    changes += 1;
    isPending(true);
    byId('saved').hidden = true;
    clearTimeout(timer);
    timer = window.setTimeout(() => (keeping = keeping.then(keepNow)), WAIT_MS);
  });
  addEventListener('beforeunload', (event) => {
    const { phase, job, source } = store.state;
    const underWay = phase === 'running' && (job?.settled ?? 0) > 0 && source?.files && !source.gallery;
    if (pending || underWay) event.preventDefault();
  });
  rememberRuns(store);
  works.offer();
}

/**
 * Remembers the run that goes on, as long as it does.
 *
 * @param {import('../store.js').Store} store
 */
function rememberRuns(store) {
  let timer = 0;
  let isKnown = false;
  /** @type {Promise<unknown>} One after the other; without storage nothing is remembered. */
  let doing = Promise.resolve();
  const then = (/** @type {(runs: typeof import('../saved/cut-off.js')) => unknown} */ act) => {
    doing = doing.then(() => import('../saved/cut-off.js').then(act)).catch(() => {});
  };
  store.watch(['phase', 'job'], ({ phase, job, source }) => {
    clearTimeout(timer);
    const goesOn = phase === 'running' && source?.files && !source.gallery && !(job instanceof SavedJob);
    if (goesOn)
      timer = window.setTimeout(() => {
        isKnown = true;
        const { state } = store;
        then((runs) => runs.remember(state));
      }, LONG_MS);
    else if (isKnown) {
      isKnown = false;
      then((runs) => runs.forgetRun());
    }
  });
}

/**
 * Which work a run belongs to: a run of the same clip takes the place of the one before, unless that was corrected by
 * hand; what was opened again is the work that it was.
 */
class Names {
  /** @param {() => string | null} opened the work that was opened again last */
  constructor(opened) {
    this.opened = opened;
    /** @type {WeakMap<object, string>} */
    this.ofJob = new WeakMap();
    /** @type {{job: import('../run/job.js').AnyJob, id: string, corrected: boolean} | null} */
    this.last = null;
  }

  /**
   * @param {import('../store.js').State} state with work
   * @returns {string}
   */
  of({ job: anyJob }) {
    const job = /** @type {import('../run/job.js').AnyJob} */ (anyJob);
    const again = this.last && this.last.job.source === job.source && !this.last.corrected ? this.last.id : null;
    const opened = job instanceof SavedJob ? this.opened() : null;
    const id = this.ofJob.get(job) ?? opened ?? again ?? `work-${Date.now()}`;
    this.ofJob.set(job, id);
    const corrected = (job.corrector?.count() ?? 0) > 0;
    this.last = { job, id, corrected };
    return id;
  }
}

/** @param {Pick<import('../page.js').Page, 'store' | 'app'>} page */
function worksList({ store, app }) {
  const dialog = /** @type {HTMLDialogElement} */ (byId('works'));
  /** @type {string | null} The work that was opened again and is not on screen yet. */
  let opened = null;
  const open = async (/** @type {Saved} */ saved) => {
    dialog.close();
    byId('saved').hidden = true;
    opened = saved.id;
    await app.openWork(saved.name, () => reopened(saved));
  };
  const drop = async (/** @type {{id: string}} */ { id }) => {
    await forget(id);
    await update();
  };
  const update = async () => {
    const works = await kept();
    byId('works-open').hidden = works.length === 0;
    byId('works-list').replaceChildren(...works.map((saved) => lineOf(saved, open, drop)));
    if (works.length === 0) dialog.close();
    return works;
  };
  const list = async () => {
    await update();
    if (!dialog.open) dialog.showModal();
  };
  for (const id of ['works-open', 'saved-all']) byId(id).addEventListener('click', list);
  byId('works-close').addEventListener('click', () => dialog.close());
  connectDialog(dialog);

  /** Offers the run that was cut off, or else the last work, unless something was opened meanwhile. */
  const offer = async () => {
    const works = await update();
    const runs = (await stored()).length > works.length ? await import('../saved/cut-off.js') : null;
    const run = await runs?.cutOff();
    const last = run ?? works[0];
    if (!last || store.state.source?.files) return;
    const { name } = last;
    byId('saved-text').textContent = run ? say`The run of ${name} was cut off.` : say`Your work on ${name} was kept.`;
    if (run) byId('saved-open').textContent = say`Run again: ${name}`;
    byId('saved-all').hidden = works.length < (run ? 1 : 2);
    byId('saved').hidden = false;
    byId('saved-open').addEventListener('click', () => (run ? again(run) : open(works[0])));
    byId('saved-forget').addEventListener('click', () => {
      byId('saved').hidden = true;
      drop(last);
    });
  };
  const again = async (/** @type {import('../saved/cut-off.js').Run} */ run) => {
    byId('saved').hidden = true;
    // The new run is remembered by itself.
    await forget(run.id);
    await app.openRun(run);
  };
  const takeOpened = () => {
    const id = opened;
    opened = null;
    return id;
  };
  return { offer, update, takeOpened };
}

/**
 * @param {Saved} saved
 * @param {(saved: Saved) => void} open
 * @param {(saved: Saved) => void} drop
 */
function lineOf(saved, open, drop) {
  const when = new Date(saved.at).toLocaleString(shownLanguage(), { dateStyle: 'medium', timeStyle: 'short' });
  const { frames } = saved.about.take;
  const facts = [
    when,
    saved.edits ? say`${frames} frames, corrected` : say`${frames} frames`,
    bytes(bytesOf(saved)),
  ].join(' · ');
  const name = h('span', { class: 'work-name' }, saved.name, h('span', { class: 'work-facts' }, facts));
  const opener = h(
    'button',
    { type: 'button', 'aria-label': say`Open ${saved.name}`, 'data-open': saved.id, click: () => open(saved) },
    'Open',
  );
  // Deleting is done by the second press.
  const deleter = h(
    'button',
    {
      type: 'button',
      'aria-label': say`Delete ${saved.name}`,
      click: () => {
        if (deleter.dataset.sure) return drop(saved);
        deleter.dataset.sure = 'asked';
        deleter.textContent = say('Delete for good?');
        deleter.setAttribute('aria-label', say`Delete ${saved.name} for good?`);
      },
      blur: () => {
        delete deleter.dataset.sure;
        deleter.textContent = say('Delete');
        deleter.setAttribute('aria-label', say`Delete ${saved.name}`);
      },
    },
    'Delete',
  );
  return h('li', { class: 'work' }, name, opener, deleter);
}
