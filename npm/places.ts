// Where the package's own files are when they are not beside its modules, and what is said where they are not found.

import { TraceCutError, checkedOptions } from './check/errors.js';
import { type WasmSource, checkWorker } from './check/options.js';

/** Where workers come from: the address of `worker.bundle.js`, or a function that starts one. */
export type WorkerSource = URL | string | (() => Worker);

/** Where the package's files are, for calls that do not say so themselves. */
export interface Places {
  /** `tracecut_bg.wasm`, which every session needs. */
  wasm?: WasmSource;
  /**
   * `decoder_bg.wasm`, which reads PNG and JPEG files, enlarges masks and makes COCO's run lengths and tables of them.
   */
  decoder?: WasmSource;
  /** `worker.bundle.js`, in browsers (Node has threads of its own); false for none. */
  worker?: WorkerSource | boolean;
}

/**
 * What was said, and how: the build with the files inside gives functions, so that nothing is unpacked before it is
 * wanted.
 */
export const places: { wasm?: unknown; decoder?: unknown; worker?: WorkerSource | boolean } = {};

/**
 * Says where the package's files are, once for all calls that come after: for tools that do not carry them along. What is
 * not named stays as it is; `undefined` means beside the package's modules again.
 *
 * ```js
 * configure({ wasm: '/tracecut_bg.wasm', decoder: '/decoder_bg.wasm', worker: '/worker.bundle.js' });
 * ```
 */
export function configure(where: Places) {
  const given = checkedOptions(where, ['wasm', 'decoder', 'worker']);
  if (given.worker !== undefined) checkWorker(given.worker);
  Object.assign(places, given);
}

/** What is said of each file, by the option that says where it is. */
const FILES = { wasm: 'tracecut_bg.wasm', decoder: 'decoder_bg.wasm', worker: 'worker.bundle.js' };

/** The way out where a file is not found. */
export function wayOut(name: keyof typeof FILES) {
  const file = FILES[name];
  return `If your bundler leaves it out, serve a copy of tracecut/dist/${file} and say where: configure({ ${name}: '/${file}' }); or use tracecut/inline`;
}

/** An address that is made from the module's own, which scripts that are no modules do not know. */
export function known(name: keyof typeof FILES, make: () => URL, advice: string = wayOut(name)) {
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
 */
export function workerAt(address: URL | string): Worker {
  try {
    return new Worker(address, { type: 'module' });
  } catch {
    return importing(new URL(address, globalThis.location?.href));
  }
}

const foreign = new Map<string, string>();

/** A worker of the page's own that imports one from elsewhere. */
export function importing({ href }: URL) {
  const text = foreign.get(href) ?? URL.createObjectURL(blobOf(`import ${JSON.stringify(href)};`));
  foreign.set(href, text);
  return new Worker(text, { type: 'module' });
}

export function blobOf(script: string) {
  return new Blob([script], { type: 'text/javascript' });
}

/** A part of the package that is loaded when it is first needed. */
export async function part<T>(loading: Promise<T>): Promise<T> {
  try {
    return await loading;
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    const words = `a module of the package could not be loaded: ${cause}. Service workers load none later: use tracecut/inline`;
    throw new TraceCutError('wasm-load', words, { cause });
  }
}
