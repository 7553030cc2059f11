// Whether this engine computes what every other does: a fixed program, its results hashed.

import * as files from './export.js';
import * as library from './index.js';
import { selftestOf } from './selftest/run.js';
import * as stages from './stages.js';

/** @typedef {import('./selftest/run.js').Selftest} Selftest */
/** @typedef {import('./selftest/run.js').SelftestCheck} SelftestCheck */
/** @typedef {import('./selftest/run.js').SelftestOptions} SelftestOptions */

/**
 * Runs a fixed program on made clips, some seconds long, hashes what comes of each part of the package, and compares
 * that with what every other engine and machine gives (docs/determinism.md).
 *
 * ```js
 * const { same, checks } = await selftest();
 * if (!same) console.error(checks.filter((check) => !check.same)); // please report it
 * ```
 * @param {import('./selftest/run.js').SelftestOptions} [options]
 * @returns {Promise<import('./selftest/run.js').Selftest>}
 */
export function selftest(options) {
  return selftestOf({ ...library, ...files, ...stages }, options);
}
