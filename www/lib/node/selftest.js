// The self test in Node, and what the program `tracecut` of the npm package prints of it.

import { createHash } from 'node:crypto';
import './platform.js';
import { selftestOf } from '../selftest/run.js';

/** @type {import('../selftest/run.js').Digest} */
const digest = async (bytes) => createHash('sha256').update(bytes).digest();

/** @type {typeof import('../selftest.js').selftest} */
export const selftest = async (options) => selftestOf(options, digest);
