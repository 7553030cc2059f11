// Whether this engine computes what every other does: a fixed program, its results hashed.

import * as files from './export.js';
import * as library from './index.js';
import { type Selftest, type SelftestOptions, selftestOf } from './selftest/run.js';
import * as stages from './stages.js';

/**
 * Runs a fixed program on made clips, some seconds long, hashes what comes of each part of the package, and compares
 * that with what every other engine and machine gives (docs/determinism.md).
 *
 * ```js
 * const { same, checks } = await selftest();
 * if (!same) console.error(checks.filter((check) => !check.same)); // please report it
 * ```
 */
export function selftest(options?: SelftestOptions): Promise<Selftest> {
  return selftestOf({ ...library, ...files, ...stages }, options);
}

export type { Selftest, SelftestCheck, SelftestOptions } from './selftest/run.js';
