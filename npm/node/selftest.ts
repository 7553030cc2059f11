// The self test in Node, and what the program `tracecut` of the npm package prints of it.

import { createHash } from 'node:crypto';
import * as files from '../export.js';
import * as library from '../index.js';
import { type Digest, selftestOf } from '../selftest/run.js';
import * as stages from '../stages.js';
import './platform.js';

const digest: Digest = async (bytes) => createHash('sha256').update(bytes).digest();

export const selftest: typeof import('../selftest.js').selftest = async (options) =>
  selftestOf({ ...library, ...files, ...stages }, options, digest);
