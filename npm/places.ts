// Locations of the package's own files that are not beside its modules, and the errors if they are not found.

import { TraceCutError, checkOptions } from './check/errors.js';
import { type WasmSource, checkWorker } from './check/options.js';

/** Source of workers: the address of `worker.bundle.js`, or a function that starts one. */
export type WorkerSource = URL | string | (() => Worker);

/** Locations of the package's files, for calls that do not give them. */
export interface Places {
  /** `tracecut_bg.wasm`, which every session needs. */
  wasm?: WasmSource;
  /** `decoder_bg.wasm`, which decodes PNG and JPEG, enlarges masks and converts them to COCO run lengths and tables. */
  decoder?: WasmSource;
  /** `worker.bundle.js`, in browsers (Node has threads of its own); false for no workers. */
  worker?: WorkerSource | boolean;
}

/** The configured locations. The build with the files inside sets functions, so that nothing is unpacked before its use. */
export const places: { wasm?: unknown; decoder?: unknown; worker?: WorkerSource | boolean } = {};

/**
 * Sets the locations of the package's files for all later calls, for tools that do not copy them. Files that are not named
 * keep their location; `undefined` means beside the package's modules again.
 *
 * ```js
 * configure({ wasm: '/tracecut_bg.wasm', decoder: '/decoder_bg.wasm', worker: '/worker.bundle.js' });
 * ```
 */
export function configure(locations: Places) {
  const checked = checkOptions(locations, ['wasm', 'decoder', 'worker']);
  if (checked.worker !== undefined) checkWorker(checked.worker);
  Object.assign(places, checked);
}

/** Names of the files, by the option that locates them. */
const FILES = { wasm: 'tracecut_bg.wasm', decoder: 'decoder_bg.wasm', worker: 'worker.bundle.js' };

/** Returns advice for a file that was not found. */
export function getMissingFileHint(name: keyof typeof FILES) {
  const file = FILES[name];
  return `If your bundler leaves it out, serve a copy of tracecut/dist/${file} and say where: configure({ ${name}: '/${file}' }); or use tracecut/inline`;
}

/** Returns an address computed from the module's own, which scripts that are no modules do not have. */
export function resolveFile(name: keyof typeof FILES, make: () => URL, advice: string = getMissingFileHint(name)) {
  try {
    return make();
  } catch (cause) {
    const message = `a script that is no module (IIFE or CommonJS) cannot know where ${FILES[name]} is. ${advice}`;
    throw new TraceCutError('wasm-load', message, { cause });
  }
}

/**
 * Starts a worker from its address. Browsers start none from another origin, such as a CDN, but allow a worker of the
 * page's own origin to import one from there.
 */
export function startWorkerAt(address: URL | string): Worker {
  try {
    return new Worker(address, { type: 'module' });
  } catch {
    return startImporter(new URL(address, globalThis.location?.href));
  }
}

const importers = new Map<string, string>();

/** Starts a worker of the page's own origin that imports another one. */
export function startImporter({ href }: URL) {
  const importer = importers.get(href) ?? URL.createObjectURL(createScriptBlob(`import ${JSON.stringify(href)};`));
  importers.set(href, importer);
  return new Worker(importer, { type: 'module' });
}

export function createScriptBlob(script: string) {
  return new Blob([script], { type: 'text/javascript' });
}

/** Loads a part of the package on its first use. */
export async function loadPart<T>(loading: Promise<T>): Promise<T> {
  try {
    return await loading;
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    const message = `a module of the package could not be loaded: ${cause}. Service workers load none later: use tracecut/inline`;
    throw new TraceCutError('wasm-load', message, { cause });
  }
}
