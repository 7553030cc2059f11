// The self test in Node, and what the program `tracecut` of the npm package prints of it.

import { createHash } from 'node:crypto';
import * as files from '../export.js';
import * as library from '../index.js';
import { selftestOf } from '../selftest/run.js';
import * as stages from '../stages.js';
import './platform.js';

/** @type {import('../selftest/run.js').Digest} */
const digest = async (bytes) => createHash('sha256').update(bytes).digest();

/** @type {typeof import('../selftest.js').selftest} */
export const selftest = async (options) => selftestOf({ ...library, ...files, ...stages }, options, digest);
