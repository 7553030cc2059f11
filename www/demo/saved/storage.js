/**
 * Works, kept in the browser's own storage: they survive a reload and a closed tab. Each clip has one place. When there
 * are too many, the oldest that nobody has corrected go; what was corrected goes by the user's hand alone. @module
 */

const DATABASE = 'tracecut';
const TABLE = 'work';

/** Works that are kept, and how many bytes of all together. */
export const MOST_WORKS = 8;
const MOST_BYTES = 2 ** 31;

/**
 * A clip's work as it is kept.
 *
 * @typedef {object} Saved
 * @property {string} id of the clip: kept again it takes its own place
 * @property {string} name of the clip
 * @property {number} at when it was kept, milliseconds since 1970
 * @property {File[]} files that the clip was opened from
 * @property {Uint8Array} project masks before edits, as `saveProject` made them
 * @property {import('../library.js').SavedEdits | null} edits
 * @property {About} about
 * @property {boolean} corrected
 * @property {Blob | null} picture a small one: a frame with its masks
 * @property {Version[]} earlier runs of the clip that were corrected, the newest first
 */

/** One of several results of a clip. @typedef {Omit<Saved, 'id' | 'name' | 'files' | 'corrected' | 'earlier'>} Version */

/**
 * What it takes to open the clip as it was, and to show the result as it was; works of earlier versions have no `look`.
 * `run` says which run the result is of, `within` that there are corrections in the masks themselves.
 *
 * @typedef {{name: string, take: import('../source.js').Take, changed: [string, number | boolean | string][],
 *   look?: import('./look.js').Look, run?: string, within?: boolean}} About
 */

/**
 * @param {Saved} saved
 * @returns {Promise<boolean>} whether it is kept: not where only corrected works could make room
 */
export async function keep(saved) {
  const works = await kept();
  const before = works.find(({ id }) => id === saved.id);
  const slot = before ? inPlaceOf(before, saved) : saved;
  const others = works.filter(({ id }) => id !== saved.id);
  const going = leaving(slot, others);
  if (!going) return false;
  const left = others.filter((one) => !holdsCorrections(one) && !going.includes(one));
  for (;;) {
    try {
      await put(slot);
      break;
    } catch (error) {
      // The browser may give less room.
      const oldest = going.pop() ?? left.pop();
      if (/** @type {Error} */ (error).name !== 'QuotaExceededError') throw error;
      if (!oldest) return false;
      await forget(oldest.id);
    }
  }
  for (const { id } of going) await forget(id);
  return true;
}

/**
 * A clip's newest result takes the place of the one before. What was corrected of another run stays beside it.
 *
 * @param {Saved} before
 * @param {Saved} saved
 * @returns {Saved}
 */
function inPlaceOf({ at, project, edits, about, corrected, picture, earlier }, saved) {
  const last = corrected ? [{ at, project, edits, about, picture }] : [];
  const others = [...last, ...earlier].filter((one) => one.about.run !== saved.about.run);
  // A clip that was closed meanwhile has no frames to draw.
  return { ...saved, picture: saved.picture ?? picture, earlier: others };
}

/**
 * @param {Saved} work that is to be kept
 * @param {Saved[]} others the newest first
 * @returns {Saved[] | null} those that make room; null where that would have to be a corrected one
 */
function leaving(work, others) {
  let [count, bytes] = [1, bytesOf(work)];
  /** @type {Saved[]} */
  const going = [];
  for (const one of [...others.filter(holdsCorrections), ...others.filter((other) => !holdsCorrections(other))]) {
    count += 1;
    bytes += bytesOf(one);
    if (count <= MOST_WORKS && bytes <= MOST_BYTES) continue;
    if (holdsCorrections(one)) return null;
    going.push(one);
  }
  return going;
}

/** @param {Saved} work */
function holdsCorrections({ corrected, earlier }) {
  return corrected || earlier.length > 0;
}

/** @param {Saved | import('./cut-off.js').Run} record */
export async function put(record) {
  await request('readwrite', (table) => table.put(record, record.id));
}

/** Names of runs that go on begin so. */
export const RUN = 'run-';

/** @returns {Promise<Saved[]>} the newest first; none where there is no storage */
export async function kept() {
  const works = (await stored()).filter(({ id }) => !id.startsWith(RUN));
  // Earlier versions of the page kept less.
  return works.map((work) => ({ ...work, ...upgraded(work) }));
}

/** @param {Saved} work */
function upgraded({ edits, corrected = (edits?.edits.length ?? 0) > 0, earlier = [], picture = null }) {
  return { corrected, earlier, picture };
}

/** @returns {Promise<Saved[]>} works, and runs that go on or were cut off */
export async function stored() {
  try {
    const [works, keys] = await Promise.all([
      request('readonly', (table) => table.getAll()),
      request('readonly', (table) => table.getAllKeys()),
    ]);
    // Both are in the order of the keys. What an earlier version kept has no name of its own.
    const named = works.map((work, k) => ({ ...work, id: String(keys[k]) }));
    return named.sort((a, b) => b.at - a.at);
  } catch {
    return [];
  }
}

/** @param {string} id */
export async function forget(id) {
  await request('readwrite', (table) => table.delete(id));
}

/** @param {Pick<Saved, 'files' | 'project' | 'earlier'>} saved */
export function bytesOf({ files, project, earlier }) {
  return [...files.map(({ size }) => size), ...earlier.map((one) => one.project.byteLength)].reduce(
    (sum, size) => sum + size,
    project.byteLength,
  );
}

/**
 * @template T
 * @param {IDBTransactionMode} mode
 * @param {(table: IDBObjectStore) => IDBRequest<T>} ask
 * @returns {Promise<T>} when it is on the disk
 */
async function request(mode, ask) {
  const database = await new Promise((/** @type {(opened: IDBDatabase) => void} */ resolve, reject) => {
    const opening = indexedDB.open(DATABASE, 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore(TABLE);
    opening.onsuccess = () => resolve(opening.result);
    opening.onerror = () => reject(opening.error);
    opening.onblocked = () => reject(new Error('another tab holds the storage'));
  });
  try {
    return await new Promise((resolve, reject) => {
      const transaction = database.transaction(TABLE, mode);
      const asked = ask(transaction.objectStore(TABLE));
      transaction.oncomplete = () => resolve(asked.result);
      transaction.onerror = () => reject(transaction.error);
      transaction.onabort = () => reject(transaction.error);
    });
  } finally {
    database.close();
  }
}
