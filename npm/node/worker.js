// A thread of Node: it serves a session (`worker: true`), or helps one. Started by `createSession` there.

import { parentPort, workerData } from 'node:worker_threads';
import { help, serve } from '../worker/serve.js';

if (workerData?.port) help(workerData.port, workerData.module, workerData.parameters);
else if (parentPort) {
  serve(/** @type {import('../worker/protocol.js').Port} */ (/** @type {unknown} */ (parentPort)));
  /** @type {import('node:worker_threads').MessagePort} */ (parentPort).start();
}
