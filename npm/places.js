// Where the package's own files are when they are not beside its modules, and what is said where they are not found.

import { TraceCutError, checkedOptions } from './check/errors.js';
import { checkWorker } from './check/options.js';

/**
 * Where workers come from: the address of `worker.bundle.js`, or a function that starts one.
 * @typedef {URL | string | (() => Worker)} WorkerSource
 */

/**
 * Where the package's files are, for calls that do not say so themselves.
 * @typedef {object} Places
 * @property {import('./check/options.js').WasmSource} [wasm] `tracecut_bg.wasm`, which every session needs
 * @property {import('./check/options.js').WasmSource} [decoder] `decoder_bg.wasm`, which reads PNG and JPEG files, enlarges
 *   masks and makes COCO's run lengths and tables of them
 * @property {WorkerSource | boolean} [worker] `worker.bundle.js`, in browsers (Node has threads of its own); false for
 *   none
 */

/**
 * What was said, and how: the build with the files inside gives functions, so that nothing is unpacked before it is
 * wanted.
 * @type {{wasm?: unknown, decoder?: unknown, worker?: WorkerSource | boolean}}
 */
export const places = {};

/**
 * Says where the package's files are, once for all calls that come after: for tools that do not carry them along. What is
 * not named stays as it is; `undefined` means beside the package's modules again.
 *
 * ```js
 * configure({ wasm: '/tracecut_bg.wasm', decoder: '/decoder_bg.wasm', worker: '/worker.bundle.js' });
 * ```
 * @param {Places} where
 */
export function configure(where) {
  const given = checkedOptions(where, ['wasm', 'decoder', 'worker']);
  if (given.worker !== undefined) checkWorker(given.worker);
  Object.assign(places, given);
}

/** What is said of each file, by the option that says where it is. */
const FILES = { wasm: 'tracecut_bg.wasm', decoder: 'decoder_bg.wasm', worker: 'worker.bundle.js' };

/**
 * The way out where a file is not found.
 * @param {keyof typeof FILES} name
 */
export function wayOut(name) {
  const file = FILES[name];
  return `If your bundler leaves it out, serve a copy of tracecut/dist/${file} and say where: configure({ ${name}: '/${file}' }); or use tracecut/inline`;
}

/**
 * An address that is made from the module's own, which scripts that are no modules do not know.
 * @param {keyof typeof FILES} name
 * @param {() => URL} make
 * @param {string} [advice]
 */
export function known(name, make, advice = wayOut(name)) {
  try {
    return make();
  } catch (cause) {
    const words = `a script that is no module (IIFE or CommonJS) cannot know where ${FILES[name]} is. ${advice}`;
    throw new TraceCutError('wasm-load', words, { cause });
  }
}

/**
 * A worker from its address. Browsers start none from another origin, such as a CDN's, but let one of the page's own
 * import it from there.
 * @param {URL | string} address
 * @returns {Worker}
 */
export function workerAt(address) {
  try {
    return new Worker(address, { type: 'module' });
  } catch {
    return importing(new URL(address, globalThis.location?.href));
  }
}

/** @type {Map<string, string>} */
const foreign = new Map();

/**
 * A worker of the page's own that imports one from elsewhere.
 * @param {URL} address
 */
export function importing({ href }) {
  const text = foreign.get(href) ?? URL.createObjectURL(blobOf(`import ${JSON.stringify(href)};`));
  foreign.set(href, text);
  return new Worker(text, { type: 'module' });
}

/** @param {string} script */
export function blobOf(script) {
  return new Blob([script], { type: 'text/javascript' });
}

/**
 * A part of the package that is loaded when it is first needed.
 * @template T
 * @param {Promise<T>} loading
 * @returns {Promise<T>}
 */
export async function part(loading) {
  try {
    return await loading;
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    const words = `a module of the package could not be loaded: ${cause}. Service workers load none later: use tracecut/inline`;
    throw new TraceCutError('wasm-load', words, { cause });
  }
}
