/**
 * Work on clips is kept in the browser as it goes, and the run that goes on is remembered. Fetched when the user opens a
 * clip, or something was kept.
 * @module
 */

import { SavedJob } from '../run/saved-job.js';
import { Works } from './works.js';

/** @typedef {import('../store.js').State} State */

/** Changes within this time are kept together, in milliseconds. */
const WAIT_MS = 700;

/** A run that takes no longer need not be remembered, in milliseconds. */
const LONG_MS = 1000;

/**
 * @param {Pick<import('../page.js').Page, 'store' | 'app'>} page
 * @returns {Works}
 */
export function keepWork({ store, app }) {
  const works = new Works({ store, app }, () => last && keepSoon(last));
  let timer = 0;
  /** Work as it is now, which is still to be kept: another clip may be on screen by then. @type {State | null} */
  let last = null;
  const isPending = (/** @type {boolean} */ now) => document.body.toggleAttribute('data-unkept', now);
  /** @type {Promise<void>} One after the other. */
  let keeping = Promise.resolve();
  const keepNow = async (/** @type {State} */ state) => {
    // No storage, or too little: leaving is asked about.
    if (!(await works.keep(state).catch(() => false))) return;
    document.body.dataset.kept = String(Date.now());
    // What changed while it was packed is kept by the next.
    if (last !== state) return;
    last = null;
    isPending(false);
  };
  const keepSoon = (/** @type {State} */ state) => (keeping = keeping.then(() => keepNow(state)));
  store.watch(['phase', 'found', 'edges', 'hidden', 'ground'], (state) => {
    if (!isWork(state)) return;
    if (last && last.job !== state.job) keepSoon(last);
    last = state;
    isPending(true);
    clearTimeout(timer);
    timer = window.setTimeout(() => keepSoon(state), WAIT_MS);
  });
  addEventListener('beforeunload', (event) => {
    const { phase, job, source } = store.state;
    const underWay = phase === 'running' && (job?.settled ?? 0) > 0 && source?.files;
    if (last || underWay) event.preventDefault();
  });
  rememberRuns(store);
  return works;
}

/**
 * @param {State} state
 * @returns {boolean} whether there is work: masks of a clip of the user's own
 */
function isWork({ phase, found, source, job }) {
  return phase === 'done' && Boolean(found?.points && job?.corrections?.of.result && source?.files);
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
    const goesOn = phase === 'running' && source?.files && !(job instanceof SavedJob);
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
