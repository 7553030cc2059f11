// A run that goes on is remembered: what cuts it off, a reload or a killed tab, costs time alone. Fetched when there is
// such a run.

import { RUN, type Saved, type Storage } from './slots.js';
import { filesOf } from './work.js';
import type { State } from './store.js';

export type Run = Pick<Saved, 'id' | 'name' | 'at' | 'files' | 'about'>;

/** So long a page is waited for that was closed, in milliseconds. */
const WAIT_MS = 2000;

export class RunMemory {
  /** The run of this page, and what ends the hold on it. */
  own: { id: string; release: () => void } | null = null;

  /** @param locks names that pages hold as long as they are there */
  constructor(
    readonly storage: Storage,
    readonly locks?: Pick<LockManager, 'request'>,
  ) {}

  async remember(state: State) {
    const { name, take, changed } = state;
    this.own ??= this.hold(`${RUN}${crypto.randomUUID()}`);
    const about = { name, take, changed: [...changed] };
    await this.storage.put({ id: this.own.id, name, at: Date.now(), files: filesOf(state), about });
  }

  /** The run has ended, or nobody wants it any more. */
  async forget() {
    if (!this.own) return;
    const { id, release } = this.own;
    this.own = null;
    release();
    await this.storage.forget(id);
  }

  /** Returns the newest that was cut off; of others nothing stays. */
  async cutOff(): Promise<Run | undefined> {
    const runs = (await this.storage.stored()).filter(({ id }) => id.startsWith(RUN));
    const isFree = await Promise.all(runs.map(({ id }) => this.canHold(id)));
    const [newest, ...others] = runs.filter((_, k) => isFree[k]);
    await Promise.all(others.map(({ id }) => this.storage.forget(id)));
    return newest;
  }

  /** Whether a run goes on nowhere; other tabs hold theirs. A page that was closed holds its own for a moment. */
  async canHold(id: string): Promise<boolean> {
    const signal = AbortSignal.timeout(WAIT_MS);
    return this.locks?.request(id, { signal }, () => true).catch(() => false) ?? true;
  }

  /** Holds a name as long as this page is there. Where another page holds it, this one waits in line. */
  hold(id: string) {
    let release = () => {};
    const until = new Promise((done: (value?: undefined) => void) => (release = done));
    this.locks?.request(id, () => until);
    return { id, release };
  }
}
