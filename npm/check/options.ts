// The options of a session, checked.

import { checkWholeNumber, illegal, isPlainObject } from './errors.js';
import type { ParameterOptions } from '../parameters.js';
import type { WorkerSource } from '../places.js';

/** Source of the wasm file, if it is not beside the package. */
export type WasmSource = URL | string | Response | BufferSource | WebAssembly.Module;

/** The options of a session that are no parameters of the method. */
export interface SessionSettings {
  /**
   * Default parameters: `'fast'` takes half the time and loses some small or fast objects, `'paper'` computes masks as
   * the paper does.
   */
  preset?: 'default' | 'fast' | 'paper';
  /** The wasm file, if it is not beside the package; `configure` sets it for all calls. */
  wasm?: WasmSource;
  /**
   * The wasm file that decodes PNG and JPEG and enlarges masks, if it is not beside the package. It is fetched when the
   * first file is pushed.
   */
  decoder?: WasmSource;
  /**
   * False to run a browser session on the calling thread. In Node, where that is the default, true runs it on a thread of
   * its own. An address (of `worker.bundle.js`, one file) or a function that starts a worker sets its source.
   */
  worker?: boolean | WorkerSource;
  /**
   * Number of threads, 1 to 64, each with some memory; results do not depend on it. Defaults to all but one of the
   * machine's, at most 8, or 1 with `worker: false`.
   */
  threads?: number;
}

/** Options of a session: the parameter tree, on top of a preset, and settings of this layer. */
export type SessionOptions = ParameterOptions & SessionSettings;

export type EngineOptions = {
  wasm?: WasmSource;
  decoder?: WasmSource;
  worker?: boolean | WorkerSource;
  threads?: number;
  maxPixels: number;
  parameters: Record<string, unknown>;
};

/** Most pixels of a frame if `clip.maxPixels` is not given. */
export const MAX_PIXELS = 2 ** 26;

/** Most threads of a session. */
const MAX_THREADS = 64;

/** Parameters are two levels deep: anything much deeper is a mistake, or an object that contains itself. */
const MAX_DEPTH = 4;

/**
 * Separates this layer's settings from the parameters and copies the latter without `undefined` values. Rust checks
 * names, types and ranges of parameters; here only values that cannot be passed on are refused.
 */
export function splitOptions(options: SessionOptions = {}): EngineOptions {
  if (!isPlainObject(options)) throw illegal('param', 'options', options, 'an object such as {flow: {patchStride: 5}}');
  const { wasm, decoder, worker, threads, ...parameters } = options;
  if (worker !== undefined) checkWorker(worker);
  if (threads !== undefined) checkWholeNumber('param', 'threads', threads, 1, MAX_THREADS);
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

/** Throws unless the value can be the option `worker`. */
export function checkWorker(worker: unknown) {
  if (['boolean', 'function', 'string'].includes(typeof worker) || worker instanceof URL) return;
  throw illegal('param', 'worker', worker, 'true, false, an address or a function that starts one');
}
