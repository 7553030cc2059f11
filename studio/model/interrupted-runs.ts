// Remembers the current run, so that it can be restarted after a reload or a crash. Loaded when needed.

import { RUN_PREFIX, type SavedProject, type ProjectStorage } from './saved-projects.js';
import { storedFiles } from './project-file.js';
import type { State } from './store.js';

export type InterruptedRun = Pick<SavedProject, 'id' | 'name' | 'at' | 'files' | 'about'>;

/** Time to wait for the lock of a closing page, in milliseconds; chosen by eye. */
const LOCK_TIMEOUT_MS = 2000;

export class RunMemory {
  /** The run of this page, and the function that releases its lock. */
  current: { id: string; release: () => void } | null = null;

  /** @param locks held by pages while they are open */
  constructor(
    readonly storage: ProjectStorage,
    readonly locks?: Pick<LockManager, 'request'>,
  ) {}

  async remember(state: State) {
    const { name, trim, changed } = state;
    this.current ??= this.hold(`${RUN_PREFIX}${crypto.randomUUID()}`);
    const about = { name, trim, changed: [...changed] };
    await this.storage.put({ id: this.current.id, name, at: Date.now(), files: storedFiles(state), about });
  }

  async forget() {
    if (!this.current) return;
    const { id, release } = this.current;
    this.current = null;
    release();
    await this.storage.remove(id);
  }

  /** Returns the newest interrupted run and removes older ones. */
  async findInterrupted(): Promise<InterruptedRun | undefined> {
    const runs = (await this.storage.list()).filter(({ id }) => id.startsWith(RUN_PREFIX));
    const isFree = await Promise.all(runs.map(({ id }) => this.canHold(id)));
    const [newest, ...older] = runs.filter((_, k) => isFree[k]);
    await Promise.all(older.map(({ id }) => this.storage.remove(id)));
    return newest;
  }

  /** Returns whether no page holds the run. A page that was just closed may hold it for a moment. */
  async canHold(id: string): Promise<boolean> {
    const signal = AbortSignal.timeout(LOCK_TIMEOUT_MS);
    return this.locks?.request(id, { signal }, () => true).catch(() => false) ?? true;
  }

  /** Requests a lock that is held while this page is open. */
  hold(id: string) {
    let release = () => {};
    const released = new Promise((resolve: (value?: undefined) => void) => (release = resolve));
    this.locks?.request(id, () => released);
    return { id, release };
  }
}
