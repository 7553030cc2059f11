/** The browser's own storage, where works are kept and runs remembered: they survive a reload and a closed tab. @module */

const DATABASE = 'tracecut';
const TABLE = 'work';

/** @typedef {import('../model/slots.js').Saved} Saved */

/** @param {Saved | import('../model/cut-off.js').Run} record */
export async function put(record) {
  await request('readwrite', (table) => table.put(record, record.id));
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
