// Saves projects as they change, and remembers the current run.

import { SavedJob } from './project-file.js';
import type { RunMemory } from './interrupted-runs.js';
import type { State, Store } from './store.js';

/** Time without changes after which a project is saved, in milliseconds; chosen by eye. */
const SAVE_DELAY_MS = 700;

/** Shorter runs are not remembered, in milliseconds; chosen by eye. */
const MIN_RUN_MS = 1000;

export class Autosave {
  timer: ReturnType<typeof setTimeout> | undefined = undefined;
  /** The newest state that is not saved yet; another clip may be on screen by then. */
  unsaved: State | null = null;
  /** Serialises saving. */
  saving: Promise<void> = Promise.resolve();

  /**
   * @param save resolves to false if storage is full
   * @param onPending called when there are unsaved changes and when they are saved
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
    // No or full storage: the page asks before it is closed.
    if (!(await this.save(state).catch(() => false))) return;
    // Changes made while it was saved are saved next.
    const isPending = this.unsaved !== state;
    if (!isPending) this.unsaved = null;
    this.onPending(isPending);
  }

  /** True if closing the page would lose work. */
  get hasUnsaved() {
    const { phase, job, source } = this.store.state;
    const isRunning = phase === 'running' && (job?.settledFrames ?? 0) > 0 && source?.files;
    return Boolean(this.unsaved || isRunning);
  }
}

/** Returns whether the state has masks of a user's clip. */
function isSavable({ phase, analysis, source, job }: State): boolean {
  return phase === 'done' && Boolean(analysis && job?.corrections.target.result && source?.files);
}

/** Remembers the current run until it ends. */
export function rememberRuns(store: Store, memory: () => Promise<Pick<RunMemory, 'remember' | 'forget'>>) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let isRemembered = false;
  /** Serialises access; without storage nothing is remembered. */
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
