/**
 * A run that goes on is remembered: what cuts it off, a reload or a killed tab, costs time alone. Fetched when there is
 * such a run.
 * @module
 */

import { RUN, forget, put, stored } from './storage.js';
import { filesOf } from './work.js';

/** @typedef {Pick<import('./storage.js').Saved, 'id' | 'name' | 'at' | 'files' | 'about'>} Run */

/** So long a page is waited for that was closed, in milliseconds. */
const WAIT_MS = 2000;

/** The run of this page, and what ends the hold on it. @type {{id: string, release: () => void} | null} */
let own = null;

/** @param {import('../store.js').State} state with a run */
export async function remember(state) {
  const { name, take, changed } = state;
  own ??= held(`${RUN}${crypto.randomUUID()}`);
  const run = { id: own.id, name, at: Date.now(), files: filesOf(state), about: { name, take, changed: [...changed] } };
  await put(run);
}

/** The run has ended, or nobody wants it any more. */
export async function forgetRun() {
  if (!own) return;
  const { id, release } = own;
  own = null;
  release();
  await forget(id);
}

/** @returns {Promise<Run | undefined>} the newest that was cut off; of others nothing stays */
export async function cutOff() {
  const runs = (await stored()).filter(({ id }) => id.startsWith(RUN));
  const isFree = await Promise.all(runs.map(({ id }) => canHold(id)));
  const [newest, ...others] = runs.filter((_, k) => isFree[k]);
  await Promise.all(others.map(({ id }) => forget(id)));
  return newest;
}

/**
 * Whether a run goes on nowhere; other tabs hold theirs. A page that was closed holds its own for a moment.
 *
 * @param {string} id
 * @returns {Promise<boolean>}
 */
async function canHold(id) {
  const signal = AbortSignal.timeout(WAIT_MS);
  return navigator.locks?.request(id, { signal }, () => true).catch(() => false) ?? true;
}

/**
 * Holds a name as long as this page is there. Where another page holds it, this one waits in line.
 *
 * @param {string} id
 */
function held(id) {
  let release = () => {};
  const until = new Promise((/** @type {(value?: undefined) => void} */ done) => (release = done));
  navigator.locks?.request(id, () => until);
  return { id, release };
}
