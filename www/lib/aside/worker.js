// A module worker for what takes long beside sessions: PNG files, archives, large pictures; one for all.

import { doHere } from './here.js';

const port = /** @type {Worker} */ (/** @type {unknown} */ (globalThis));
port.addEventListener('message', async ({ data: { id, task } }) => {
  try {
    const bytes = await doHere(task);
    port.postMessage({ id, bytes }, [bytes.buffer]);
  } catch (error) {
    port.postMessage({ id, error: String(error) });
  }
});
