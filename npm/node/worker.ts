// A Node thread that serves (`worker: true`) or helps a session; started by `createSession`.

import { type MessagePort, parentPort, workerData } from 'node:worker_threads';
import { help, serve } from '../worker/serve.js';
import type { Port } from '../worker/protocol.js';

if (workerData?.port) help(workerData.port, workerData.module, workerData.parameters);
else if (parentPort) {
  serve(parentPort as unknown as Port);
  parentPort.start();
}
