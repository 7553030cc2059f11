// Stores projects and runs in IndexedDB.

import type { InterruptedRun } from '../model/interrupted-runs.js';
import type { SavedProject } from '../model/saved-projects.js';

const DATABASE = 'tracecut';
const STORE = 'work';

export async function put(record: SavedProject | InterruptedRun) {
  await request('readwrite', (table) => table.put(record, record.id));
}

/** Returns projects and runs, newest first; empty without storage. */
export async function list(): Promise<SavedProject[]> {
  try {
    const [records, keys] = await Promise.all([
      request('readonly', (table) => table.getAll()),
      request('readonly', (table) => table.getAllKeys()),
    ]);
    // Both are in the order of the keys. Records of earlier versions have no id.
    const named = records.map((record, k) => ({ ...record, id: String(keys[k]) }));
    return named.sort((a, b) => b.at - a.at);
  } catch {
    return [];
  }
}

export async function remove(id: string) {
  await request('readwrite', (table) => table.delete(id));
}

async function request<T>(mode: IDBTransactionMode, ask: (table: IDBObjectStore) => IDBRequest<T>): Promise<T> {
  const database = await new Promise((resolve: (opened: IDBDatabase) => void, reject) => {
    const opening = indexedDB.open(DATABASE, 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore(STORE);
    opening.onsuccess = () => resolve(opening.result);
    opening.onerror = () => reject(opening.error);
    opening.onblocked = () => reject(new Error('another tab holds the storage'));
  });
  try {
    return await new Promise((resolve, reject) => {
      const transaction = database.transaction(STORE, mode);
      const request = ask(transaction.objectStore(STORE));
      transaction.oncomplete = () => resolve(request.result);
      transaction.onerror = () => reject(transaction.error);
      transaction.onabort = () => reject(transaction.error);
    });
  } finally {
    database.close();
  }
}
