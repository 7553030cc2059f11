/**
 * Work is not lost: it is kept in the browser whenever it has changed, beside what was kept before; the last is offered
 * again after a reload, all of them in a list; and nobody leaves by mistake.
 * @module
 */

import { byId } from '../dom.js';
import { SavedJob } from '../run/clip-job.js';
import { Packer, isWork } from '../saved/work.js';
import { keep } from '../saved/storage.js';
import { worksList } from './works.js';

/** Changes within this time are kept together, in milliseconds. */
const WAIT_MS = 700;

/** @param {Pick<import('./panels.js').Page, 'store' | 'app' | 'library'>} page */
export function savedPanel({ store, app, library }) {
  const packer = new Packer(library);
  const works = worksList({ store, app, library });
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
  works.offer();
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
