// Instances of the wasm module, each with a memory of its own: what fails in one leaves the others alone, and a memory,
// which cannot shrink, goes when its session does.

import { makeGlue } from './glue.js';
import { TraceCutError } from './errors.js';

/** @typedef {typeof import('./tracecut.js')} Glue */
/** @typedef {{glue: Glue | undefined, ended: TraceCutError | undefined}} Instance */

/**
 * Starts a new instance.
 * @param {WebAssembly.Module} module
 * @returns {Promise<Instance>}
 */
export async function instance(module) {
  const glue = makeGlue();
  await glue.default({ module_or_path: module });
  return { glue, ended: undefined };
}

/**
 * Calls into an instance. An error that Rust returned has a code. Anything else is a panic or a trap, after which the
 * instance cannot be trusted: it ends, with every object in it.
 * @template T
 * @param {Instance} owner
 * @param {(glue: Glue) => T} call
 * @returns {T}
 */
export function guarded(owner, call) {
  const { glue } = owner;
  if (!glue) throw owner.ended;
  try {
    return call(glue);
  } catch (error) {
    if (error instanceof Error && 'code' in error && typeof error.code === 'string') {
      throw new TraceCutError(/** @type {import('./errors.js').ErrorCode} */ (error.code), error.message);
    }
    const words = panicWords(glue) ?? String(error);
    owner.glue = undefined;
    owner.ended = new TraceCutError(
      'poisoned',
      `the engine stopped on an internal error: ${words}. Create a new session.`,
      { cause: error },
    );
    throw owner.ended;
  }
}

/**
 * Gives up an instance: its memory is freed when nothing else refers to its objects. Calls into it say that its owner
 * is closed.
 * @param {Instance} owner
 * @param {string} what
 */
export function end(owner, what) {
  owner.glue = undefined;
  owner.ended ??= new TraceCutError('closed', `the ${what} is closed; create a new one`);
}

/**
 * Other exports still run after a panic, so the instance can say what happened.
 * @param {Glue} glue
 */
function panicWords(glue) {
  try {
    return glue.panicMessage();
  } catch {
    return undefined;
  }
}
