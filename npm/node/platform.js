// What Node has in the place of browsers' ways: files from the disk, and work on the calling thread, with threads beside
// it where they help.

import { existsSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { availableParallelism } from 'node:os';
import { Worker } from 'node:worker_threads';
import { TraceCutError } from '../check/errors.js';
import { known } from '../places.js';
import { loadModule, loader, setPlatform } from '../platform.js';

// Bundlers that carry files along look for these very expressions.
const packagedFile = () => new URL('../tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('../decoder_bg.wasm', import.meta.url);

setPlatform({
  loadModule: loader('wasm', load, () => readPackaged('wasm', 'tracecut_bg.wasm', packagedFile)),
  loadDecoder: loader('decoder', load, () => readPackaged('decoder', 'decoder_bg.wasm', packagedDecoder)),
  startWorker: startThread,
  inProcess: true,
  startHelper,
  cores: availableParallelism,
});

/** @type {NonNullable<import('../platform.js').Platform['startHelper']>} */
function startHelper(data) {
  const port = /** @type {import('node:worker_threads').MessagePort} */ (/** @type {unknown} */ (data.port));
  const worker = new Worker(new URL('./worker.js', import.meta.url), {
    workerData: data,
    transferList: [port],
    // Those of the process may be for its script alone, as `--input-type` is.
    execArgv: [],
  });
  // A session that nobody closed keeps no process alive.
  worker.unref();
  return {
    watch(onLost) {
      worker.on('error', onLost);
      worker.on('exit', onLost);
    },
    end: () => void worker.terminate(),
  };
}

/** @param {import('../check/options.js').WasmSource} source */
function load(source) {
  if (source instanceof URL && source.protocol === 'file:') return readModule(source);
  return typeof source === 'string' && !/^[a-z][a-z\d+.-]+:/i.test(source) ? readModule(source) : loadModule(source);
}

/**
 * A file beside this module. Where a bundler gives an address of its own in its place, as webpack does, it is looked for
 * where this module was when it was bundled.
 * @param {'wasm' | 'decoder'} name
 * @param {string} file
 * @param {() => URL} make
 */
async function readPackaged(name, file, make) {
  const url = known(name, make, wayOut(name, file));
  const here = import.meta.url;
  const candidates = url.href.startsWith('file:') ? [new URL(url.href)] : [];
  candidates.push(new URL(`../${file}`, here));
  const found = candidates.find((candidate) => existsSync(candidate)) ?? candidates[0];
  return readModule(/** @type {URL} */ (found), wayOut(name, file));
}

/**
 * The way out where a bundler has left a file behind.
 * @param {string} name
 * @param {string} file
 */
function wayOut(name, file) {
  return `If your bundler leaves it out, keep the package out of the bundle (external: ['tracecut'], serverExternalPackages: ['tracecut']), or copy tracecut/dist/${file} and say where: configure({ ${name}: 'path/of/${file}' })`;
}

/**
 * @param {URL | string} place
 * @param {string} [hint]
 */
async function readModule(place, hint) {
  try {
    return await loadModule(await readFile(place));
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    const words = `${place instanceof URL ? place.href : place} could not be read: ${String(cause)}`;
    throw new TraceCutError('wasm-load', hint ? `${words}. ${hint}` : words, { cause });
  }
}

/** @typedef {(event: any) => void} Listener */

/**
 * Starts a thread that serves a session, or helps one. It keeps the process alive only while something is asked of it:
 * a session that nobody closed does not.
 * @returns {globalThis.Worker}
 */
function startThread() {
  return /** @type {globalThis.Worker} */ (/** @type {unknown} */ (new Thread()));
}

class Thread {
  // Options of the process may be for its script alone, as `--input-type` is.
  #worker = new Worker(new URL('./worker.js', import.meta.url), { execArgv: [] });
  #unanswered = 0;
  #ended = false;

  constructor() {
    this.#worker.unref();
  }

  /**
   * @param {{id: number, type: string}} message
   * @param {import('node:worker_threads').Transferable[]} [transfer]
   */
  postMessage(message, transfer) {
    this.#worker.postMessage(message, transfer);
    if (message.id === 0 || message.type === 'abort') return;
    this.#unanswered += 1;
    this.#worker.ref();
  }

  /**
   * @param {'message' | 'messageerror' | 'error'} type
   * @param {Listener} listener
   */
  addEventListener(type, listener) {
    if (type === 'error') this.#onError(listener);
    else if (type === 'messageerror') this.#worker.on('messageerror', () => listener({}));
    else this.#worker.on('message', (data) => this.#onMessage(data, listener));
  }

  terminate() {
    this.#ended = true;
    void this.#worker.terminate();
  }

  /**
   * @param {{id: number, type: string}} data
   * @param {Listener} listener
   */
  #onMessage(data, listener) {
    if (data.id !== 0 && data.type !== 'progress') {
      this.#unanswered -= 1;
      if (this.#unanswered === 0) this.#worker.unref();
    }
    listener({ data });
  }

  /** @param {Listener} listener */
  #onError(listener) {
    this.#worker.on('error', (error) => listener({ message: String(error) }));
    this.#worker.on('exit', (code) => {
      if (!this.#ended) listener({ message: `the thread ended with code ${code}` });
    });
  }
}
