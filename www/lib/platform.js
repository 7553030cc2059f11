// What differs between browsers and Node. These are the browser's ways; the entries for Node put theirs in their place.

import { illegal } from './errors.js';
import { loadModule } from './load.js';
import { importing, known, places, wayOut, workerAt } from './places.js';

/** @typedef {import('./options.js').WasmSource} WasmSource */

/**
 * @typedef {object} Platform
 * @property {(source?: WasmSource) => Promise<WebAssembly.Module>} loadModule
 * @property {(source?: WasmSource) => Promise<WebAssembly.Module>} loadDecoder
 * @property {(() => Worker) | undefined} startWorker
 * @property {boolean} [inProcess] whether work stays on the calling thread where nobody asks for a worker
 * @property {(() => Worker) | undefined} [startAside]
 * @property {(data: {module: WebAssembly.Module, parameters: Record<string, unknown>, port: MessagePort}) =>
 *   import('./crew.js').HelperWorker} [startHelper] where sessions run on the calling thread: a worker that helps one
 * @property {() => number | undefined} cores as many threads as the machine runs at once, where known
 */

// Bundlers look for these very expressions, and for the workers'.
const packagedFile = () => new URL('./tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('./decoder_bg.wasm', import.meta.url);

/** @type {Platform} */
export let platform = {
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

/** @param {Platform} other where the package runs, if that is no browser */
export function setPlatform(other) {
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
    return new Worker(new URL('./aside/worker.js', import.meta.url), { type: 'module' });
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
 * @param {boolean | import('./places.js').WorkerSource | undefined} worker
 * @returns {(() => Worker) | undefined}
 */
export function workerStarter(worker) {
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

/** @param {unknown} source */
const isAddress = (source) => typeof source === 'string' || source instanceof URL;

/**
 * @param {import('./places.js').WorkerSource} source
 * @returns {() => Worker}
 */
function from(source) {
  if (typeof source !== 'function') return () => workerAt(source);
  return () => {
    const made = source();
    if (typeof made?.postMessage !== 'function') throw illegal('param', 'worker()', made, 'a Worker');
    return made;
  };
}

/**
 * Loads once, however often it is called; after a failure the next call tries again.
 * @template T
 * @param {() => Promise<T>} load
 * @returns {() => Promise<T>}
 */
export function once(load) {
  /** @type {Promise<T> | undefined} */
  let loading;
  return () => {
    loading ??= load();
    loading.catch(() => (loading = undefined));
    return loading;
  };
}

/**
 * Loads what a call names, or what `configure` named, or what the package brings; the latter two once.
 * @param {'wasm' | 'decoder'} name
 * @param {(source: WasmSource) => Promise<WebAssembly.Module>} load
 * @param {() => Promise<WebAssembly.Module>} loadPackaged
 * @returns {(source?: WasmSource) => Promise<WebAssembly.Module>}
 */
export function loader(name, load, loadPackaged) {
  const packaged = once(loadPackaged);
  /** @type {unknown} */
  let last;
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
