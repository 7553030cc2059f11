// What differs between browsers and Node: where wasm files come from, and how workers start. These are the browser's ways;
// the entries for Node put theirs in their place.

import { TraceCutError, illegal, typeTag } from './check/errors.js';
import { type WorkerSource, importing, known, places, wayOut, workerAt } from './places.js';
import type { WasmSource } from './check/options.js';
import type { HelperWorker } from './worker/helpers.js';

export interface HelperData {
  module: WebAssembly.Module;
  parameters: Record<string, unknown>;
  port: MessagePort;
}

export interface Platform {
  loadModule: (source?: WasmSource) => Promise<WebAssembly.Module>;
  loadDecoder: (source?: WasmSource) => Promise<WebAssembly.Module>;
  startWorker: (() => Worker) | undefined;
  /** Whether work stays on the calling thread where nobody asks for a worker. */
  inProcess?: boolean;
  startAside?: (() => Worker) | undefined;
  /** Where sessions run on the calling thread: a worker that helps one. */
  startHelper?: (data: HelperData) => HelperWorker;
  /** As many threads as the machine runs at once, where known. */
  cores: () => number | undefined;
}

// Bundlers look for these very expressions, and for the workers'.
const packagedFile = () => new URL('./tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('./decoder_bg.wasm', import.meta.url);

export let platform: Platform = {
  loadModule: loader('wasm', loadModule, async () => loadModule(known('wasm', packagedFile), wayOut('wasm'))),
  loadDecoder: loader('decoder', loadModule, async () =>
    loadModule(known('decoder', packagedDecoder), wayOut('decoder')),
  ),
  get startWorker() {
    return typeof Worker === 'undefined' ? undefined : startWorker;
  },
  get startAside() {
    return typeof Worker === 'undefined' ? undefined : asideStarter();
  },
  cores: () => globalThis.navigator?.hardwareConcurrency,
};

export function setPlatform(other: Platform) {
  platform = other;
}

function startWorker() {
  try {
    return new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
  } catch {
    return importing(known('worker', () => new URL('worker.js', packagedFile())));
  }
}

function startAside() {
  try {
    return new Worker(new URL('./aside-worker.js', import.meta.url), { type: 'module' });
  } catch {
    return importing(known('worker', () => new URL('aside/worker.js', packagedFile())));
  }
}

/** How the worker for what is done aside starts. */
function asideStarter() {
  const { worker = true } = places;
  if (worker === false) return undefined;
  return worker === true ? startAside : from(worker);
}

/**
 * How workers start, as a call's option says, or `configure`, or the package; nothing where the work stays in this
 * thread.
 */
export function workerStarter(worker: boolean | WorkerSource | undefined): (() => Worker) | undefined {
  const asked = worker ?? (platform.inProcess ? false : places.worker);
  if (asked === false) return undefined;
  if (!platform.startWorker) {
    if (worker === undefined) return undefined;
    const expected = 'false or nothing: this thread can start no module workers, so the work runs in it';
    throw illegal('unsupported', 'worker', worker, expected);
  }
  if (platform.inProcess && isAddress(asked))
    throw illegal('unsupported', 'worker', worker, 'true, false or nothing: threads of Node need no address');
  const source = asked === true && !platform.inProcess ? places.worker : asked;
  return typeof source === 'boolean' || source === undefined ? platform.startWorker : from(source);
}

const isAddress = (source: unknown) => typeof source === 'string' || source instanceof URL;

function from(source: WorkerSource): () => Worker {
  if (typeof source !== 'function') return () => workerAt(source);
  return () => {
    const made = source();
    if (typeof made?.postMessage !== 'function') throw illegal('param', 'worker()', made, 'a Worker');
    return made;
  };
}

/** Loads once, however often it is called; after a failure the next call tries again. */
export function once<T>(load: () => Promise<T>): () => Promise<T> {
  let loading: Promise<T> | undefined;
  return () => {
    loading ??= load();
    loading.catch(() => (loading = undefined));
    return loading;
  };
}

/** Loads what a call names, or what `configure` named, or what the package brings; the latter two once. */
export function loader(
  name: 'wasm' | 'decoder',
  load: (source: WasmSource) => Promise<WebAssembly.Module>,
  loadPackaged: () => Promise<WebAssembly.Module>,
): (source?: WasmSource) => Promise<WebAssembly.Module> {
  const packaged = once(loadPackaged);
  let last: unknown;
  let configured = packaged;
  return (source) => {
    if (source !== undefined) return load(source);
    const place = places[name];
    if (place === undefined) return packaged();
    if (place !== last) {
      last = place;
      configured = once(async () => load(typeof place === 'function' ? place() : place));
    }
    return configured();
  };
}

/** The smallest module with a SIMD instruction in it. */
const SIMD_PROBE = [
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
];

/**
 * Compiles the wasm module from wherever it is.
 * @param hint what to do where it is not found
 */
export async function loadModule(source: WasmSource, hint = ''): Promise<WebAssembly.Module> {
  if (typeof WebAssembly === 'undefined')
    throw new TraceCutError('unsupported', 'this JavaScript engine has no WebAssembly');
  if (source instanceof WebAssembly.Module || typeTag(source) === 'WebAssembly.Module') return source;
  if (typeof source === 'string' || source instanceof URL)
    return fromResponse(await fetched(source, hint), String(source), hint);
  if (typeTag(source) === 'Response') return fromResponse(source as Response, 'the response');
  if (typeTag(source) === 'ArrayBuffer' || ArrayBuffer.isView(source))
    return compile(source as BufferSource, 'the bytes given');
  throw illegal('param', 'wasm', source, 'a URL, a Response, bytes or a WebAssembly.Module');
}

async function fetched(url: string | URL, hint: string) {
  try {
    return await fetch(url);
  } catch (cause) {
    throw new TraceCutError('wasm-load', advised(`${url} could not be fetched: ${words(cause)}`, hint), { cause });
  }
}

async function fromResponse(response: Response, name: string, hint = '') {
  if (!response.ok) {
    const words = `${name} could not be fetched: the server answered ${response.status}`;
    throw new TraceCutError('wasm-load', advised(words, hint));
  }
  let spare: Response | undefined;
  if (response.headers.get('Content-Type') === 'application/wasm' && !response.bodyUsed) {
    spare = response.clone();
    try {
      return await WebAssembly.compileStreaming(response);
    } catch {
      // Compiled from its bytes, which says what is wrong.
    }
  }
  return compile(await bodyOf(spare ?? response, name, hint), name, hint);
}

/** The bytes of an answer, unless the network goes while they come. */
async function bodyOf(response: Response, name: string, hint: string) {
  try {
    return await response.arrayBuffer();
  } catch (cause) {
    const said = `${name} came only in part: ${words(cause)}. Try again`;
    throw new TraceCutError('wasm-load', advised(said, hint), { cause });
  }
}

async function compile(bytes: BufferSource, name: string, hint = '') {
  const view = ArrayBuffer.isView(bytes)
    ? new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength)
    : new Uint8Array(bytes);
  if (view[0] === 0x3c) {
    const check =
      "check that the .wasm file is where the URL says (with Vite before 8, set optimizeDeps.exclude to ['tracecut'])";
    throw new TraceCutError('wasm-load', advised(`${name} is a page of HTML, not WebAssembly: ${check}`, hint));
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
    throw new TraceCutError('wasm-load', `${name} could not be compiled: ${words(cause)}`, { cause });
  }
}

function advised(words: string, hint: string) {
  return hint ? `${words}. ${hint}` : words;
}

function words(error: unknown) {
  return error instanceof Error ? error.message : String(error);
}
