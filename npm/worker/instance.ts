// Instances of the wasm module, each with its own memory: a failure in one does not affect the others, and a memory, which
// cannot shrink, is freed with its session.

import { TraceCutError, throwIfRust } from '../check/errors.js';
import { makeGlue } from '../glue.js';

export type Glue = typeof import('../tracecut.js');
export type Instance = {
  glue: Glue | undefined;
  memory: WebAssembly.Memory | undefined;
  error: TraceCutError | undefined;
};

/** Starts a new instance. */
export async function startInstance(module: WebAssembly.Module): Promise<Instance> {
  const glue = makeGlue();
  try {
    const { memory } = await glue.default({ module_or_path: module });
    return { glue, memory, error: undefined };
  } catch (error) {
    throw isOutOfMemory(error) ? createMemoryError(0, error) : error;
  }
}

/**
 * Calls into an instance. An error that Rust returned has a code. Anything else is a panic or a trap, after which the
 * instance cannot be trusted: it ends, with all its objects.
 */
export function callInstance<T>(owner: Instance, call: (glue: Glue) => T): T {
  const { glue, memory } = owner;
  if (!glue) throw owner.error;
  try {
    return call(glue);
  } catch (error) {
    throwIfRust(error);
    // V8's stack keeps the instance alive until it is formatted.
    if (error instanceof Error) void error.stack;
    const panic = readPanic(glue);
    const bytes = memory?.buffer.byteLength ?? 0;
    owner.error =
      isOutOfMemory(error) || (panic ? /capacity overflow/.test(panic) : isUnreachable(error) && isFull(memory))
        ? createMemoryError(bytes, error)
        : new TraceCutError(
            'poisoned',
            `the engine stopped on an internal error: ${panic ?? error}. Create a new session.`,
            { cause: error },
          );
    owner.glue = owner.memory = undefined;
    throw owner.error;
  }
}

/**
 * Releases an instance: its memory is freed when nothing else refers to its objects. Later calls fail, as its owner is
 * closed.
 */
export function release(owner: Instance, name: string) {
  owner.glue = owner.memory = undefined;
  owner.error ??= new TraceCutError('closed', `the ${name} is closed; create a new one`);
}

/** Returns the message of a panic: other exports still run after one. */
function readPanic(glue: Glue) {
  try {
    return glue.panicMessage();
  } catch {
    return undefined;
  }
}

/** Returns true if the JavaScript engine had no memory for an array or an instance; a full stack is a `RangeError` too. */
function isOutOfMemory(error: unknown) {
  return error instanceof RangeError && !/stack/i.test(error.message);
}

/** Returns true for Rust's trap without memory, which has no panic. (A size that no memory could hold is a panic.) */
function isUnreachable(error: unknown) {
  return error instanceof WebAssembly.RuntimeError && /unreachable/i.test(error.message);
}

/** Returns true if a memory cannot grow by a GiB, or double: growing lists request as much, less if they are small. */
function isFull(memory: WebAssembly.Memory | undefined) {
  try {
    memory?.grow(Math.max(memory.buffer.byteLength, 2 ** 30) / 65536);
    return false;
  } catch {
    return true;
  }
}

function createMemoryError(bytes: number, cause: unknown) {
  const mebibytes = Math.ceil(bytes / 2 ** 20);
  return new TraceCutError(
    'memory',
    `the engine ran out of memory at ${mebibytes} MiB. Create a new session with fewer frames or a smaller clip.maxSide.`,
    { cause },
  );
}
