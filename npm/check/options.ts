// The options of a session, checked.

import { illegal, isPlainObject, wholeNumber } from './errors.js';
import type { ParameterOptions } from '../parameters.js';
import type { WorkerSource } from '../places.js';

/** Where the wasm file comes from, when not from beside the package. */
export type WasmSource = URL | string | Response | BufferSource | WebAssembly.Module;

/** The options of a session that are no parameters of the method. */
export interface SessionSettings {
  /**
   * What the parameters are that are not given: `'fast'` takes half of the time and loses some of what is small or
   * fast, `'paper'` makes masks as the paper does.
   */
  preset?: 'default' | 'fast' | 'paper';
  /** Where the wasm file is, when not beside the package; `configure` says it for all calls. */
  wasm?: WasmSource;
  /**
   * Where the wasm file is that reads PNG and JPEG files and enlarges masks, when not beside the package; it is
   * fetched when the first file is pushed.
   */
  decoder?: WasmSource;
  /**
   * False to run a browser's session on the calling thread; in Node, which does so of itself, true to run it on a
   * thread of its own, so that the calling one stays free; an address (of `worker.bundle.js`, one file) or a function
   * that starts one says where the worker is.
   */
  worker?: boolean | WorkerSource;
  /**
   * To work on, 1 to 64, each with some memory; results are the same for any number. If not given, all but one of the
   * machine's, at most 8, and 1 with `worker: false`.
   */
  threads?: number;
}

/** Options of a session: the parameter tree, over a preset if there is one, and settings of this layer. */
export type SessionOptions = ParameterOptions & SessionSettings;

export type SplitOptions = {
  wasm?: WasmSource;
  decoder?: WasmSource;
  worker?: boolean | WorkerSource;
  threads?: number;
  maxPixels: number;
  parameters: Record<string, unknown>;
};

/** Most pixels of a frame where `clip.maxPixels` says nothing. */
export const MAX_PIXELS = 2 ** 26;

/** Most threads that can be asked for. */
const MAX_THREADS = 64;

/** Parameters are two levels deep; anything much deeper is a mistake, or an object that contains itself. */
const MAX_DEPTH = 4;

/**
 * Separates this layer's settings from the parameters and copies the latter, leaving out what is `undefined`. Names,
 * types and ranges of parameters are checked in Rust; here only what cannot get that far is refused.
 */
export function splitOptions(options: SessionOptions = {}): SplitOptions {
  if (!isPlainObject(options)) throw illegal('param', 'options', options, 'an object such as {flow: {patchStride: 5}}');
  const { wasm, decoder, worker, threads, ...parameters } = options;
  if (worker !== undefined) checkWorker(worker);
  if (threads !== undefined) wholeNumber('param', 'threads', threads, 1, MAX_THREADS);
  const maxPixels = parameters.clip?.maxPixels ?? MAX_PIXELS;
  return { wasm, decoder, worker, threads, maxPixels, parameters: copyTree(parameters, '', 0) };
}

function copyTree(tree: Record<string, unknown>, prefix: string, depth: number): Record<string, unknown> {
  const copy: Record<string, unknown> = {};
  for (const [key, value] of Object.entries(tree)) {
    const name = prefix + key;
    if (value === undefined) continue;
    if (isPlainObject(value) && depth < MAX_DEPTH) {
      copy[key] = copyTree(value, `${name}.`, depth + 1);
    } else if (typeof value === 'number' || typeof value === 'boolean' || typeof value === 'string') {
      copy[key] = value;
    } else {
      throw illegal('param', name, value, 'a number, true or false, or a name');
    }
  }
  return copy;
}

/** Refuses what says nothing about workers. */
export function checkWorker(worker: unknown) {
  if (['boolean', 'function', 'string'].includes(typeof worker) || worker instanceof URL) return;
  throw illegal('param', 'worker', worker, 'true, false, an address or a function that starts one');
}
