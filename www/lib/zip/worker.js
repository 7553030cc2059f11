// A module worker that makes PNG files and archives; one for all, started when it is needed.

import { zipHere } from './here.js';

const port = /** @type {Worker} */ (/** @type {unknown} */ (globalThis));
port.addEventListener('message', ({ data: { id, task } }) => {
  try {
    const bytes = zipHere(task);
    port.postMessage({ id, bytes }, [bytes.buffer]);
  } catch (error) {
    port.postMessage({ id, error: String(error) });
  }
});
