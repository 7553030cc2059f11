// The program of `checks.js` run, its results hashed and compared with what they are everywhere else.

import { illegal, isPlainObject } from '../errors.js';
import { checks } from './checks.js';
import { EXPECTED } from './expected.js';

/**
 * One result, hashed: `hash` and `expected` are the first 64 bits of its SHA-256, in hexadecimal digits; `same` tells
 * whether they are equal.
 * @typedef {{readonly name: string, readonly what: string, readonly hash: string, readonly expected: string,
 *   readonly same: boolean}} SelftestCheck
 */

/**
 * What became of a self test: `same` is true where every check is the same and the package is of the `version` that the
 * hashes are of.
 * @typedef {{readonly version: string, readonly same: boolean, readonly checks: readonly SelftestCheck[]}} Selftest
 */

/**
 * Options of `selftest`.
 * @typedef {object} SelftestOptions
 * @property {(check: SelftestCheck) => void} [onCheck] told of each check as soon as it is done
 * @property {AbortSignal} [signal] ends the work: the promise rejects with its reason
 * @property {import('../options.js').WasmSource} [wasm] as of a session
 * @property {import('../options.js').WasmSource} [decoder] as of a session
 * @property {boolean | import('../places.js').WorkerSource} [worker] as of a session
 * @property {number} [threads] as of a session; the hashes are the same for any number
 */

/** How bytes are hashed here. @typedef {(bytes: Uint8Array<ArrayBuffer>) => Promise<Uint8Array>} Digest */

/** How many there are. */
export const NUM_CHECKS = Object.keys(EXPECTED.hashes).length;

const LEGAL = ['onCheck', 'signal', 'wasm', 'decoder', 'worker', 'threads'];

/**
 * Runs the self test with a package that is loaded already.
 * @param {import('./checks.js').Library} library
 * @param {SelftestOptions} [options]
 * @param {Digest} [digest]
 * @returns {Promise<Selftest>}
 */
export async function selftestOf(library, options = {}, digest = digestHere(library)) {
  if (!isPlainObject(options)) throw illegal('param', 'options', options, `an object of ${LEGAL.join(', ')}`);
  const unknown = Object.entries(options).find(([name]) => !LEGAL.includes(name));
  if (unknown) throw illegal('param', unknown[0], unknown[1], LEGAL.join(', '));
  const { onCheck, signal, ...settings } = options;
  /** @type {SelftestCheck[]} */
  const done = [];
  for await (const [name, what, parts] of checks(library, settings, signal)) {
    signal?.throwIfAborted();
    const hash = hexOf(await digest(joined(parts)));
    const expected = EXPECTED.hashes[name] ?? 'nothing';
    const check = { name, what, hash, expected, same: hash === expected };
    done.push(check);
    onCheck?.(check);
  }
  const { version } = library;
  const same = done.every((check) => check.same) && done.length === NUM_CHECKS && version === EXPECTED.version;
  return { version, same, checks: done };
}

/**
 * @param {import('./checks.js').Library} library
 * @returns {Digest}
 */
function digestHere({ TraceCutError }) {
  const subtle = globalThis.crypto?.subtle;
  if (!subtle)
    throw new TraceCutError('unsupported', 'hashes need crypto.subtle: pages have it by https and on localhost');
  return async (bytes) => new Uint8Array(await subtle.digest('SHA-256', bytes));
}

/** @param {import('./checks.js').Parts} parts */
function joined(parts) {
  const list = [...parts].map(({ buffer, byteOffset, byteLength }) => new Uint8Array(buffer, byteOffset, byteLength));
  const all = new Uint8Array(list.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of list) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** @param {Uint8Array} hash */
function hexOf(hash) {
  return Array.from(hash.subarray(0, 8), (byte) => byte.toString(16).padStart(2, '0')).join('');
}
