// Platform functions for Node instead of the browser's: files from the disk, and work on the calling thread, with helper
// threads.

import { existsSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { availableParallelism } from 'node:os';
import { type MessagePort, type Transferable, Worker } from 'node:worker_threads';
import { TraceCutError } from '../check/errors.js';
import { type HelperData, type Platform, createLoader, loadModule, resolveFile, setPlatform } from '../platform.js';
import type { WasmSource } from '../check/options.js';
import type { HelperWorker } from '../worker/helpers.js';

// Bundlers that copy assets search for these exact expressions.
const packagedFile = () => new URL('../tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('../decoder_bg.wasm', import.meta.url);

setPlatform({
  loadModule: createLoader('wasm', load, () => readPackaged('wasm', 'tracecut_bg.wasm', packagedFile)),
  loadDecoder: createLoader('decoder', load, () => readPackaged('decoder', 'decoder_bg.wasm', packagedDecoder)),
  startWorker: startThread,
  inProcess: true,
  startHelper,
  readVideo,
  cores: availableParallelism,
});

/** Reads a video with ffmpeg; a string with a protocol is an address, any other a path. */
async function readVideo(address: string | URL, options: { signal?: AbortSignal; maxPixels?: number }) {
  const { framesOfVideo } = await import('./video.js');
  const isAddress = typeof address === 'string' && /^[a-z][a-z\d+.-]+:\/\//i.test(address);
  return framesOfVideo(isAddress ? new URL(address) : address, options);
}

function startHelper(data: HelperData): HelperWorker {
  const port = data.port as unknown as MessagePort;
  const worker = new Worker(new URL('./worker.js', import.meta.url), {
    workerData: data,
    transferList: [port],
    // The process's own options may be for its script alone, as `--input-type` is.
    execArgv: [],
  });
  // A session that was never closed must not keep the process alive.
  worker.unref();
  return {
    watch(onLost) {
      worker.on('error', onLost);
      worker.on('exit', onLost);
    },
    end: () => void worker.terminate(),
  };
}

function load(source: WasmSource) {
  if (source instanceof URL && source.protocol === 'file:') return readModule(source);
  return typeof source === 'string' && !/^[a-z][a-z\d+.-]+:/i.test(source) ? readModule(source) : loadModule(source);
}

/**
 * Reads a file beside this module. If a bundler such as webpack replaced its address by one of its own, it is searched for
 * where this module was when it was bundled.
 */
async function readPackaged(name: 'wasm' | 'decoder', file: string, make: () => URL) {
  const url = resolveFile(name, make, getBundlerHint(name, file));
  const ownUrl = import.meta.url;
  const candidates = url.href.startsWith('file:') ? [new URL(url.href)] : [];
  candidates.push(new URL(`../${file}`, ownUrl));
  const existing = candidates.find((candidate) => existsSync(candidate)) ?? candidates[0];
  return readModule(existing!, getBundlerHint(name, file));
}

/** Returns advice for a file that a bundler left behind. */
function getBundlerHint(name: string, file: string) {
  return `If your bundler leaves it out, keep the package out of the bundle (external: ['tracecut'], serverExternalPackages: ['tracecut']), or copy tracecut/dist/${file} and say where: configure({ ${name}: 'path/of/${file}' })`;
}

async function readModule(place: URL | string, hint?: string) {
  try {
    return await loadModule(await readFile(place));
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    const message = `${place instanceof URL ? place.href : place} could not be read: ${String(cause)}`;
    throw new TraceCutError('wasm-load', hint ? `${message}. ${hint}` : message, { cause });
  }
}

type Listener = (event: { data?: unknown; message?: string; preventDefault?: () => void }) => void;

/**
 * Starts a thread that serves or helps a session. It keeps the process alive only while a request is pending, so a session
 * that was never closed does not.
 */
function startThread(): globalThis.Worker {
  return new Thread() as unknown as globalThis.Worker;
}

class Thread {
  // The process's own options may be for its script alone, as `--input-type` is.
  #worker = new Worker(new URL('./worker.js', import.meta.url), { execArgv: [] });
  #unanswered = 0;
  #isTerminated = false;

  constructor() {
    this.#worker.unref();
  }

  postMessage(message: { id: number; type: string }, transfer?: Transferable[]) {
    this.#worker.postMessage(message, transfer);
    if (message.id === 0 || message.type === 'abort') return;
    this.#unanswered += 1;
    this.#worker.ref();
  }

  addEventListener(type: 'message' | 'messageerror' | 'error', listener: Listener) {
    if (type === 'error') this.#onError(listener);
    else if (type === 'messageerror') this.#worker.on('messageerror', () => listener({}));
    else this.#worker.on('message', (data) => this.#onMessage(data, listener));
  }

  terminate() {
    this.#isTerminated = true;
    void this.#worker.terminate();
  }

  #onMessage(data: { id: number; type: string }, listener: Listener) {
    if (data.id !== 0 && data.type !== 'progress') {
      this.#unanswered -= 1;
      if (this.#unanswered === 0) this.#worker.unref();
    }
    listener({ data });
  }

  #onError(listener: Listener) {
    this.#worker.on('error', (error) => listener({ message: String(error) }));
    this.#worker.on('exit', (code) => {
      if (!this.#isTerminated) listener({ message: `the thread ended with code ${code}` });
    });
  }
}
