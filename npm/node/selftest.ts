// The self test in Node.

import { createHash } from 'node:crypto';
import * as files from '../export.js';
import * as library from '../index.js';
import { type Digest, runSelftest } from '../selftest/run.js';
import * as stages from '../stages.js';
import './platform.js';

const digest: Digest = async (bytes) => createHash('sha256').update(bytes).digest();

export const selftest: typeof import('../selftest.js').selftest = async (options) =>
  runSelftest({ ...library, ...files, ...stages }, options, digest);
