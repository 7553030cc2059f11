/** The last work, kept in the browser's own storage: it survives a reload and a closed tab. @module */

const DATABASE = 'tracecut';
const TABLE = 'work';
const KEY = 'last';

/**
 * Work as it is kept.
 *
 * @typedef {object} Saved
 * @property {string} name of the clip
 * @property {number} at when it was kept, milliseconds since 1970
 * @property {File[]} files that the clip was opened from
 * @property {Uint8Array} project masks before edits, as `saveProject` made them
 * @property {import('../../dist/index.js').SavedEdits | null} edits
 * @property {About} about
 */

/**
 * What it takes to open the clip as it was.
 *
 * @typedef {{name: string, take: import('../source.js').Take, changed: [string, number | boolean | string][]}} About
 */

/** @param {Saved} saved */
export async function keep(saved) {
  await request('readwrite', (table) => table.put(saved, KEY));
}

/** @returns {Promise<Saved | null>} null where there is nothing, or no storage */
export async function kept() {
  try {
    return (await request('readonly', (table) => table.get(KEY))) ?? null;
  } catch {
    return null;
  }
}

export async function forget() {
  await request('readwrite', (table) => table.delete(KEY));
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
