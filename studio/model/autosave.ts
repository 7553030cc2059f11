// Work on clips is kept in a storage as it goes, and the run that goes on is remembered.

import { SavedJob } from './saved-job.js';
import type { RunMemory } from './cut-off.js';
import type { State, Store } from './store.js';

/** Changes within this time are kept together, in milliseconds. */
const WAIT_MS = 700;

/** A run that takes no longer need not be remembered, in milliseconds. */
const LONG_MS = 1000;

export class Autosave {
  timer: ReturnType<typeof setTimeout> | undefined = undefined;
  /** Work as it is now, which is still to be kept: another clip may be on screen by then. */
  last: State | null = null;
  /** One after the other. */
  keeping: Promise<void> = Promise.resolve();

  /**
   * @param keep whether there was room
   * @param tell told when there is work to be kept, and when it has been
   */
  constructor(
    readonly store: Store,
    readonly keep: (state: State) => Promise<boolean>,
    readonly tell: (isPending: boolean) => void,
  ) {
    store.watch(['phase', 'found', 'edges', 'hidden', 'ground'], (state) => this.show(state));
  }

  show(state: State) {
    if (!isWork(state)) return;
    if (this.last && this.last.job !== state.job) this.keepSoon();
    this.last = state;
    this.tell(true);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.keepSoon(), WAIT_MS);
  }

  keepSoon() {
    const { last } = this;
    if (last) this.keeping = this.keeping.then(() => this.keepNow(last));
  }

  async keepNow(state: State) {
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

/** Returns whether there is work: masks of a clip of the user's own. */
function isWork({ phase, found, source, job }: State): boolean {
  return phase === 'done' && Boolean(found?.points && job?.corrections?.of.result && source?.files);
}

/** Remembers the run that goes on, as long as it does. */
export function rememberRuns(store: Store, memory: () => Promise<Pick<RunMemory, 'remember' | 'forget'>>) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let isKnown = false;
  /** One after the other; without storage nothing is remembered. */
  let doing: Promise<unknown> = Promise.resolve();
  const then = (act: (runs: Awaited<ReturnType<typeof memory>>) => unknown) => {
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
