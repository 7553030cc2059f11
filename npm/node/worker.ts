// A thread of Node: it serves a session (`worker: true`), or helps one. Started by `createSession` there.

import { type MessagePort, parentPort, workerData } from 'node:worker_threads';
import { help, serve } from '../worker/serve.js';
import type { Port } from '../worker/protocol.js';

if (workerData?.port) help(workerData.port, workerData.module, workerData.parameters);
else if (parentPort) {
  serve(parentPort as unknown as Port);
  parentPort.start();
}
