// A thread of Node that helps a session; started by `createSession` there.

import { workerData } from 'node:worker_threads';
import { help } from './helper.js';

help(workerData.port, workerData.module, workerData.parameters);
