/**
 * Work on clips is kept in a storage as it goes, and the run that goes on is remembered.
 * @module
 */

import { SavedJob } from './saved-job.js';

/** @typedef {import('./store.js').State} State */
/** @typedef {import('./store.js').Store} Store */

/** Changes within this time are kept together, in milliseconds. */
const WAIT_MS = 700;

/** A run that takes no longer need not be remembered, in milliseconds. */
const LONG_MS = 1000;

export class Autosave {
  /**
   * @param {Store} store
   * @param {(state: State) => Promise<boolean>} keep whether there was room
   * @param {(isPending: boolean) => void} tell told when there is work to be kept, and when it has been
   */
  constructor(store, keep, tell) {
    this.store = store;
    this.keep = keep;
    this.tell = tell;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    /** Work as it is now, which is still to be kept: another clip may be on screen by then. @type {State | null} */
    this.last = null;
    /** @type {Promise<void>} One after the other. */
    this.keeping = Promise.resolve();
    store.watch(['phase', 'found', 'edges', 'hidden', 'ground'], (state) => this.show(state));
  }

  /** @param {State} state */
  show(state) {
    if (!isWork(state)) return;
    if (this.last && this.last.job !== state.job) this.keepSoon();
    this.last = state;
    this.tell(true);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.keepSoon(), WAIT_MS);
  }

  /** Keeps what is still to be kept. */
  keepSoon() {
    const { last } = this;
    if (last) this.keeping = this.keeping.then(() => this.keepNow(last));
  }

  /** @param {State} state */
  async keepNow(state) {
    // No storage, or too little: leaving is asked about.
    if (!(await this.keep(state).catch(() => false))) return;
    // What changed while it was packed is kept by the next.
    const isPending = this.last !== state;
    if (!isPending) this.last = null;
    this.tell(isPending);
  }

  /** Whether something would be lost by leaving. */
  get loses() {
    const { phase, job, source } = this.store.state;
    const underWay = phase === 'running' && (job?.settled ?? 0) > 0 && source?.files;
    return Boolean(this.last || underWay);
  }
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
 * @param {Store} store
 * @param {() => Promise<Pick<import('./cut-off.js').RunMemory, 'remember' | 'forget'>>} memory
 */
export function rememberRuns(store, memory) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  let isKnown = false;
  /** @type {Promise<unknown>} One after the other; without storage nothing is remembered. */
  let doing = Promise.resolve();
  const then = (/** @type {(runs: Awaited<ReturnType<typeof memory>>) => unknown} */ act) => {
    doing = doing.then(() => memory().then(act)).catch(() => {});
  };
  store.watch(['phase', 'job'], ({ phase, job, source }) => {
    clearTimeout(timer);
    const goesOn = phase === 'running' && source?.files && !(job instanceof SavedJob);
    if (goesOn)
      timer = setTimeout(() => {
        isKnown = true;
        const { state } = store;
        then((runs) => runs.remember(state));
      }, LONG_MS);
    else if (isKnown) {
      isKnown = false;
      then((runs) => runs.forget());
    }
  });
}
