// Locations of the package's own files, and the differences between browsers and Node: loading of wasm files and starting of
// workers. The functions here are those for browsers; the entries for Node replace them.

import { TraceCutError, checkOptions, illegal, typeTag } from './check/errors.js';
import { type WasmSource, checkWorker } from './check/options.js';
import type { FrameAtTime } from './video/frame-list.js';
import type { HelperWorker } from './worker/helpers.js';

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

export interface HelperData {
  module: WebAssembly.Module;
  parameters: Record<string, unknown>;
  port: MessagePort;
}

export interface Platform {
  loadModule: (source?: WasmSource) => Promise<WebAssembly.Module>;
  loadDecoder: (source?: WasmSource) => Promise<WebAssembly.Module>;
  startWorker: (() => Worker) | undefined;
  /** True if work stays on the calling thread by default. */
  inProcess?: boolean;
  startAside?: (() => Worker) | undefined;
  /** Starts a helper of a session on the calling thread. */
  startHelper?: (data: HelperData) => HelperWorker;
  /** Reads the frames of a video file by its path or address, where browsers' own decoders are missing. */
  readVideo?: (
    address: string | URL,
    options: { signal?: AbortSignal; maxPixels?: number },
  ) => Promise<AsyncIterable<FrameAtTime>>;
  /** Returns the number of threads that the machine runs at once, if known. */
  cores: () => number | undefined;
}

// Bundlers search for these exact expressions, and for the ones that start workers.
const packagedFile = () => new URL('./tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('./decoder_bg.wasm', import.meta.url);

export let platform: Platform = {
  loadModule: createLoader('wasm', loadModule, async () =>
    loadModule(resolveFile('wasm', packagedFile), getMissingFileHint('wasm')),
  ),
  loadDecoder: createLoader('decoder', loadModule, async () =>
    loadModule(resolveFile('decoder', packagedDecoder), getMissingFileHint('decoder')),
  ),
  get startWorker() {
    return typeof Worker === 'undefined' ? undefined : startWorker;
  },
  get startAside() {
    return typeof Worker === 'undefined' ? undefined : getAsideStarter();
  },
  cores: () => globalThis.navigator?.hardwareConcurrency,
};

export function setPlatform(replacement: Platform) {
  platform = replacement;
}

function startWorker() {
  try {
    return new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
  } catch {
    return startImporter(resolveFile('worker', () => new URL('worker.js', packagedFile())));
  }
}

function startAside() {
  try {
    return new Worker(new URL('./aside-worker.js', import.meta.url), { type: 'module' });
  } catch {
    return startImporter(resolveFile('worker', () => new URL('aside/worker.js', packagedFile())));
  }
}

/** Returns a function that starts the worker for long tasks; undefined if there is none. */
function getAsideStarter() {
  const { worker = true } = places;
  if (worker === false) return undefined;
  return worker === true ? startAside : toStarter(worker);
}

/** Returns a function that starts workers, by a call's option, `configure` or the package; undefined without workers. */
export function getWorkerStarter(worker: boolean | WorkerSource | undefined): (() => Worker) | undefined {
  const choice = worker ?? (platform.inProcess ? false : places.worker);
  if (choice === false) return undefined;
  if (!platform.startWorker) {
    if (worker === undefined) return undefined;
    const expected = 'false or nothing: this thread can start no module workers, so the work runs in it';
    throw illegal('unsupported', 'worker', worker, expected);
  }
  if (platform.inProcess && isAddress(choice))
    throw illegal('unsupported', 'worker', worker, 'true, false or nothing: threads of Node need no address');
  const source = choice === true && !platform.inProcess ? places.worker : choice;
  return typeof source === 'boolean' || source === undefined ? platform.startWorker : toStarter(source);
}

const isAddress = (source: unknown) => typeof source === 'string' || source instanceof URL;

function toStarter(source: WorkerSource): () => Worker {
  if (typeof source !== 'function') return () => startWorkerAt(source);
  return () => {
    const worker = source();
    if (typeof worker?.postMessage !== 'function') throw illegal('param', 'worker()', worker, 'a Worker');
    return worker;
  };
}

/** Returns a function that loads once, however often it is called; after a failure the next call tries again. */
export function loadOnce<T>(load: () => Promise<T>): () => Promise<T> {
  let loading: Promise<T> | undefined;
  return () => {
    loading ??= load();
    loading.catch(() => (loading = undefined));
    return loading;
  };
}

/** Returns a loader: of the file that a call names, else of the configured one, else of the packaged; the latter two once. */
export function createLoader(
  name: 'wasm' | 'decoder',
  load: (source: WasmSource) => Promise<WebAssembly.Module>,
  loadPackaged: () => Promise<WebAssembly.Module>,
): (source?: WasmSource) => Promise<WebAssembly.Module> {
  const packaged = loadOnce(loadPackaged);
  let last: unknown;
  let configured = packaged;
  return (source) => {
    if (source !== undefined) return load(source);
    const place = places[name];
    if (place === undefined) return packaged();
    if (place !== last) {
      last = place;
      configured = loadOnce(async () => load(typeof place === 'function' ? place() : place));
    }
    return configured();
  };
}

/** A minimal module with a SIMD instruction. */
const SIMD_PROBE = [
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
];

/**
 * Compiles the wasm module from any source.
 * @param hint advice if it is not found
 */
export async function loadModule(source: WasmSource, hint = ''): Promise<WebAssembly.Module> {
  if (typeof WebAssembly === 'undefined')
    throw new TraceCutError('unsupported', 'this JavaScript engine has no WebAssembly');
  if (source instanceof WebAssembly.Module || typeTag(source) === 'WebAssembly.Module') return source;
  if (typeof source === 'string' || source instanceof URL)
    return compileResponse(await fetchModule(source, hint), String(source), hint);
  if (typeTag(source) === 'Response') return compileResponse(source as Response, 'the response');
  if (typeTag(source) === 'ArrayBuffer' || ArrayBuffer.isView(source))
    return compile(source as BufferSource, 'the bytes given');
  throw illegal('param', 'wasm', source, 'a URL, a Response, bytes or a WebAssembly.Module');
}

async function fetchModule(url: string | URL, hint: string) {
  try {
    return await fetch(url);
  } catch (cause) {
    throw new TraceCutError('wasm-load', addHint(`${url} could not be fetched: ${getMessage(cause)}`, hint), { cause });
  }
}

async function compileResponse(response: Response, name: string, hint = '') {
  if (!response.ok) {
    const message = `${name} could not be fetched: the server answered ${response.status}`;
    throw new TraceCutError('wasm-load', addHint(message, hint));
  }
  let copy: Response | undefined;
  if (response.headers.get('Content-Type') === 'application/wasm' && !response.bodyUsed) {
    copy = response.clone();
    try {
      return await WebAssembly.compileStreaming(response);
    } catch {
      // Compiled from its bytes below, with a better error message.
    }
  }
  return compile(await readBody(copy ?? response, name, hint), name, hint);
}

/** Reads the bytes of a response; throws if the network fails meanwhile. */
async function readBody(response: Response, name: string, hint: string) {
  try {
    return await response.arrayBuffer();
  } catch (cause) {
    const message = `${name} came only in part: ${getMessage(cause)}. Try again`;
    throw new TraceCutError('wasm-load', addHint(message, hint), { cause });
  }
}

async function compile(bytes: BufferSource, name: string, hint = '') {
  const view = ArrayBuffer.isView(bytes)
    ? new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength)
    : new Uint8Array(bytes);
  if (view[0] === 0x3c) {
    const check =
      "check that the .wasm file is where the URL says (with Vite before 8, set optimizeDeps.exclude to ['tracecut'])";
    throw new TraceCutError('wasm-load', addHint(`${name} is a page of HTML, not WebAssembly: ${check}`, hint));
  }
  if (!WebAssembly.validate(new Uint8Array(SIMD_PROBE))) {
    throw new TraceCutError(
      'unsupported',
      'this JavaScript engine has no WebAssembly SIMD (needs Chrome 91, Firefox 89, Safari 16.4 or Node 18)',
    );
  }
  try {
    return await WebAssembly.compile(bytes);
  } catch (cause) {
    throw new TraceCutError('wasm-load', `${name} could not be compiled: ${getMessage(cause)}`, { cause });
  }
}

function addHint(message: string, hint: string) {
  return hint ? `${message}. ${hint}` : message;
}

function getMessage(error: unknown) {
  return error instanceof Error ? error.message : String(error);
}
