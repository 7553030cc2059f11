// Checks that this engine computes the same as every other: runs a fixed program and hashes its results.

import * as files from './export.js';
import * as library from './index.js';
import { type Selftest, type SelftestOptions, runSelftest } from './selftest/run.js';
import * as stages from './stages.js';

/**
 * Runs a fixed program on synthetic clips, some seconds long, hashes the results of each part of the package, and
 * compares the hashes with the hashes of every other engine and machine (docs/determinism.md).
 *
 * ```js
 * const { same, checks } = await selftest();
 * if (!same) console.error(checks.filter((check) => !check.same)); // please report it
 * ```
 */
export function selftest(options?: SelftestOptions): Promise<Selftest> {
  return runSelftest({ ...library, ...files, ...stages }, options);
}

export type { Selftest, SelftestCheck, SelftestOptions } from './selftest/run.js';
