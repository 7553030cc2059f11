// Work on clips is kept in a storage as it goes, and the run that goes on is remembered.

import { SavedJob } from './saved-job.js';
import type { RunMemory } from './interrupted-runs.js';
import type { State, Store } from './store.js';

/** Changes within this time are kept together, in milliseconds. */
const SAVE_DELAY_MS = 700;

/** A run that takes no longer need not be remembered, in milliseconds. */
const MIN_RUN_MS = 1000;

export class Autosave {
  timer: ReturnType<typeof setTimeout> | undefined = undefined;
  /** Work as it is now, which is still to be kept: another clip may be on screen by then. */
  unsaved: State | null = null;
  /** One after the other. */
  saving: Promise<void> = Promise.resolve();

  /**
   * @param save whether there was room
   * @param onPending told when there is work to be kept, and when it has been
   */
  constructor(
    readonly store: Store,
    readonly save: (state: State) => Promise<boolean>,
    readonly onPending: (isPending: boolean) => void,
  ) {
    store.watch(['phase', 'analysis', 'edges', 'hidden', 'backdrop'], (state) => this.show(state));
  }

  show(state: State) {
    if (!isSavable(state)) return;
    if (this.unsaved && this.unsaved.job !== state.job) this.saveSoon();
    this.unsaved = state;
    this.onPending(true);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.saveSoon(), SAVE_DELAY_MS);
  }

  saveSoon() {
    const { unsaved } = this;
    if (unsaved) this.saving = this.saving.then(() => this.saveNow(unsaved));
  }

  async saveNow(state: State) {
    // No storage, or too little: leaving is asked about.
    if (!(await this.save(state).catch(() => false))) return;
    // What changed while it was packed is kept by the next.
    const isPending = this.unsaved !== state;
    if (!isPending) this.unsaved = null;
    this.onPending(isPending);
  }

  /** Whether something would be lost by leaving. */
  get hasUnsaved() {
    const { phase, job, source } = this.store.state;
    const isRunning = phase === 'running' && (job?.settledFrames ?? 0) > 0 && source?.files;
    return Boolean(this.unsaved || isRunning);
  }
}

/** Returns whether there is work: masks of a clip of the user's own. */
function isSavable({ phase, analysis, source, job }: State): boolean {
  return phase === 'done' && Boolean(analysis?.segmentation && job?.corrections?.target.result && source?.files);
}

/** Remembers the run that goes on, as long as it does. */
export function rememberRuns(store: Store, memory: () => Promise<Pick<RunMemory, 'remember' | 'forget'>>) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let isRemembered = false;
  /** One after the other; without storage nothing is remembered. */
  let queue: Promise<unknown> = Promise.resolve();
  const enqueue = (act: (runs: Awaited<ReturnType<typeof memory>>) => unknown) => {
    queue = queue.then(() => memory().then(act)).catch(() => {});
  };
  store.watch(['phase', 'job'], ({ phase, job, source }) => {
    clearTimeout(timer);
    const isRunning = phase === 'running' && source?.files && !(job instanceof SavedJob);
    if (isRunning)
      timer = setTimeout(() => {
        isRemembered = true;
        const { state } = store;
        enqueue((runs) => runs.remember(state));
      }, MIN_RUN_MS);
    else if (isRemembered) {
      isRemembered = false;
      enqueue((runs) => runs.forget());
    }
  });
}
