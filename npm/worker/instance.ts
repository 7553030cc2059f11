// Instances of the wasm module, each with a memory of its own: what fails in one leaves the others alone, and a memory,
// which cannot shrink, goes when its session does.

import { TraceCutError, throwIfRust } from '../check/errors.js';
import { makeGlue } from '../glue.js';

export type Glue = typeof import('../tracecut.js');
export type Instance = {
  glue: Glue | undefined;
  memory: WebAssembly.Memory | undefined;
  ended: TraceCutError | undefined;
};

/** Starts a new instance. */
export async function instance(module: WebAssembly.Module): Promise<Instance> {
  const glue = makeGlue();
  try {
    const { memory } = await glue.default({ module_or_path: module });
    return { glue, memory, ended: undefined };
  } catch (error) {
    throw lacksMemory(error) ? outOfMemory(0, error) : error;
  }
}

/**
 * Calls into an instance. An error that Rust returned has a code. Anything else is a panic or a trap, after which the
 * instance cannot be trusted: it ends, with every object in it.
 */
export function guarded<T>(owner: Instance, call: (glue: Glue) => T): T {
  const { glue, memory } = owner;
  if (!glue) throw owner.ended;
  try {
    return call(glue);
  } catch (error) {
    throwIfRust(error);
    // Once it is text, the stack keeps the instance no longer: V8 holds on to it until somebody looks.
    if (error instanceof Error) void error.stack;
    const words = panicWords(glue);
    const used = memory?.buffer.byteLength ?? 0;
    owner.ended =
      lacksMemory(error) || (words ? /capacity overflow/.test(words) : isUnreachable(error) && isFull(memory))
        ? outOfMemory(used, error)
        : new TraceCutError(
            'poisoned',
            `the engine stopped on an internal error: ${words ?? error}. Create a new session.`,
            { cause: error },
          );
    owner.glue = owner.memory = undefined;
    throw owner.ended;
  }
}

/**
 * Gives up an instance: its memory is freed when nothing else refers to its objects. Calls into it say that its owner
 * is closed.
 */
export function end(owner: Instance, what: string) {
  owner.glue = owner.memory = undefined;
  owner.ended ??= new TraceCutError('closed', `the ${what} is closed; create a new one`);
}

/** Other exports still run after a panic, so the instance can say what happened. */
function panicWords(glue: Glue) {
  try {
    return glue.panicMessage();
  } catch {
    return undefined;
  }
}

/** The engine of the language had no memory for an array or an instance; a stack that is full is a `RangeError` too. */
function lacksMemory(error: unknown) {
  return error instanceof RangeError && !/stack/i.test(error.message);
}

/**
 * How Rust stops where it gets no memory: without a panic, and so without words. (What no memory could hold is a panic.)
 */
function isUnreachable(error: unknown) {
  return error instanceof WebAssembly.RuntimeError && /unreachable/i.test(error.message);
}

/**
 * Whether a memory cannot grow by a GiB, or be doubled: growing lists ask for as much, and for less than that if it is
 * small.
 */
function isFull(memory: WebAssembly.Memory | undefined) {
  try {
    memory?.grow(Math.max(memory.buffer.byteLength, 2 ** 30) / 65536);
    return false;
  } catch {
    return true;
  }
}

function outOfMemory(used: number, cause: unknown) {
  const had = Math.ceil(used / 2 ** 20);
  return new TraceCutError(
    'memory',
    `the engine ran out of memory at ${had} MiB. Create a new session with fewer frames or a smaller clip.maxSide.`,
    { cause },
  );
}
