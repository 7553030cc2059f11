// The one wasm instance of this thread: started once, shared by its sessions, replaced after a panic.

import startInstance, * as glue from './tracecut.js';
import { TraceCutError } from './errors.js';

/** Grows when the instance is replaced; objects of an earlier instance are lost. */
let generation = 0;

/**
 * Starts the instance on the first call.
 * @param {WebAssembly.Module} module
 */
export async function instance(module) {
  await startInstance({ module_or_path: module });
  return generation;
}

/**
 * Calls into the instance of `born`. An error that Rust returned has a code. Anything else is a panic or a trap, after which the
 * instance cannot be trusted: a fresh one takes its place and every object of the old one is lost.
 * @template T
 * @param {number} born
 * @param {(glue: typeof import('./tracecut.js')) => T} call
 * @returns {T}
 */
export function guarded(born, call) {
  if (born !== generation) throw poisoned('another session of this thread stopped the engine');
  try {
    return call(glue);
  } catch (error) {
    if (error instanceof Error && 'code' in error && typeof error.code === 'string') {
      throw new TraceCutError(/** @type {import('./errors.js').ErrorCode} */ (error.code), error.message);
    }
    const words = panicWords() ?? String(error);
    generation += 1;
    glue.__wbg_reset_state();
    throw poisoned(words, error);
  }
}

/** Whether objects of the instance `born` still exist. */
export const alive = (/** @type {number} */ born) => born === generation;

/** Other exports still run after a panic, so the instance can say what happened. */
function panicWords() {
  try {
    return glue.panicMessage();
  } catch {
    return undefined;
  }
}

/**
 * @param {string} words
 * @param {unknown} [cause]
 */
function poisoned(words, cause) {
  return new TraceCutError('poisoned', `the engine stopped on an internal error: ${words}. Create a new session.`, { cause });
}
