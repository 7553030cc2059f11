// A run that goes on is remembered: what cuts it off, a reload or a killed tab, costs time alone. Fetched when there is
// such a run.

import { RUN_PREFIX, type SavedProject, type ProjectStorage } from './saved-projects.js';
import { storedFiles } from './project-file.js';
import type { State } from './store.js';

export type InterruptedRun = Pick<SavedProject, 'id' | 'name' | 'at' | 'files' | 'about'>;

/** So long a page is waited for that was closed, in milliseconds. */
const LOCK_TIMEOUT_MS = 2000;

export class RunMemory {
  /** The run of this page, and what ends the hold on it. */
  current: { id: string; release: () => void } | null = null;

  /** @param locks names that pages hold as long as they are there */
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

  /** The run has ended, or nobody wants it any more. */
  async forget() {
    if (!this.current) return;
    const { id, release } = this.current;
    this.current = null;
    release();
    await this.storage.remove(id);
  }

  /** Returns the newest that was cut off; of others nothing stays. */
  async findInterrupted(): Promise<InterruptedRun | undefined> {
    const runs = (await this.storage.list()).filter(({ id }) => id.startsWith(RUN_PREFIX));
    const isFree = await Promise.all(runs.map(({ id }) => this.canHold(id)));
    const [newest, ...older] = runs.filter((_, k) => isFree[k]);
    await Promise.all(older.map(({ id }) => this.storage.remove(id)));
    return newest;
  }

  /** Whether a run goes on nowhere; other tabs hold theirs. A page that was closed holds its own for a moment. */
  async canHold(id: string): Promise<boolean> {
    const signal = AbortSignal.timeout(LOCK_TIMEOUT_MS);
    return this.locks?.request(id, { signal }, () => true).catch(() => false) ?? true;
  }

  /** Holds a name as long as this page is there. Where another page holds it, this one waits in line. */
  hold(id: string) {
    let release = () => {};
    const released = new Promise((resolve: (value?: undefined) => void) => (release = resolve));
    this.locks?.request(id, () => released);
    return { id, release };
  }
}
