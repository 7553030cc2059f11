// The options of a session, checked.

import { checkOptions, checkWholeNumber, illegal, isPlainObject } from './errors.js';
import { PARAMETERS, type ParameterOptions } from '../parameters.js';
import type { WorkerSource } from '../platform.js';

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
   * machine's, but both of two, at most 8, or 1 with `worker: false`.
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

/** Names of the settings. */
const SETTINGS = ['preset', 'wasm', 'decoder', 'worker', 'threads'];

/** Names of the options of a call. */
export type OptionNames = {
  /** Those that are checked elsewhere; the error of an unknown option lists them too. */
  others?: readonly string[];
  /** Groups of parameters; all if not given. */
  groups?: readonly string[];
  /** Settings; all if not given. */
  settings?: readonly string[];
};

/**
 * Separates this layer's settings from the parameters and copies the latter without `undefined` values. Rust checks
 * types and ranges of parameters; here only values that cannot be passed on are refused.
 */
export function splitOptions(options: SessionOptions = {}, names: OptionNames = {}): EngineOptions {
  checkTree(options, names);
  const { wasm, decoder, worker, threads, ...parameters } = options;
  if (worker !== undefined) checkWorker(worker);
  if (threads !== undefined) checkWholeNumber('param', 'threads', threads, 1, MAX_THREADS);
  const maxPixels = parameters.clip?.maxPixels ?? MAX_PIXELS;
  return { wasm, decoder, worker, threads, maxPixels, parameters: copyTree(parameters) };
}

/** Throws for unknown names of settings, groups and parameters. */
function checkTree(options: SessionOptions, { others = [], groups = listGroups(), settings = SETTINGS }: OptionNames) {
  const nested = PARAMETERS.map(({ name }) => name).filter((name) => groups.includes(name.split('.')[0]!));
  checkOptions(options, [...others, ...settings, ...groups], { nested });
  for (const [group, parameters] of Object.entries(options)) {
    if (!groups.includes(group) || parameters === undefined) continue;
    const prefix = `${group}.`;
    const legal = nested.filter((name) => name.startsWith(prefix)).map((name) => name.slice(prefix.length));
    checkOptions(parameters as object, legal, { prefix });
  }
}

function listGroups() {
  return [...new Set(PARAMETERS.map(({ name }) => name.split('.')[0]!))];
}

/** Copies groups, and the parameters in them. */
function copyTree(tree: Record<string, unknown>, group = ''): Record<string, unknown> {
  const copy: Record<string, unknown> = {};
  for (const [key, value] of Object.entries(tree)) {
    if (value === undefined) continue;
    if (isPlainObject(value) && group === '') copy[key] = copyTree(value, `${key}.`);
    else if (['number', 'boolean', 'string'].includes(typeof value)) copy[key] = value;
    else throw illegal('param', group + key, value, 'a number, true or false, or a name');
  }
  return copy;
}

/** Throws unless the value can be the option `worker`. */
export function checkWorker(worker: unknown) {
  if (['boolean', 'function', 'string'].includes(typeof worker) || worker instanceof URL) return;
  throw illegal('param', 'worker', worker, 'true, false, an address or a function that starts one');
}
