// The browser's own storage, where works are kept and runs remembered: they survive a reload and a closed tab.

import type { Run } from '../model/cut-off.js';
import type { Saved } from '../model/slots.js';

const DATABASE = 'tracecut';
const TABLE = 'work';

export async function put(record: Saved | Run) {
  await request('readwrite', (table) => table.put(record, record.id));
}

/** Returns the works, and the runs that go on or were cut off. */
export async function stored(): Promise<Saved[]> {
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

export async function forget(id: string) {
  await request('readwrite', (table) => table.delete(id));
}

async function request<T>(mode: IDBTransactionMode, ask: (table: IDBObjectStore) => IDBRequest<T>): Promise<T> {
  const database = await new Promise((resolve: (opened: IDBDatabase) => void, reject) => {
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
