// The page's side of the protocol: an engine that lives in a worker of its own.

import { TraceCutError } from './errors.js';
import { transferables } from './protocol.js';

/** @typedef {import('./engine.js').Engine} Engine */
/** @typedef {import('./protocol.js').RequestType} RequestType */

/**
 * @typedef {object} Pending
 * @property {(value: any) => void} resolve
 * @property {(error: unknown) => void} reject
 * @property {(progress: import('./engine.js').Progress) => void} [onProgress]
 */

/**
 * @param {Worker} worker
 * @param {WebAssembly.Module} module
 * @param {Record<string, unknown>} parameters
 */
export async function createRemoteEngine(worker, module, parameters) {
  const engine = new RemoteEngine(worker);
  try {
    await engine.create(module, parameters);
  } catch (error) {
    engine.close();
    throw error;
  }
  return engine;
}

/** @implements {Engine} */
export class RemoteEngine {
  #worker;
  #nextId = 1;
  /** @type {Map<number, Pending>} */
  #pending = new Map();
  /** @type {TraceCutError | undefined} Why the worker is no more. */
  #ended;
  #heard = false;

  /** @param {Worker} worker */
  constructor(worker) {
    this.#worker = worker;
    worker.addEventListener('message', (event) => this.#receive(event.data));
    worker.addEventListener('messageerror', () => this.#end(lost('a message could not be read')));
    worker.addEventListener('error', (event) => {
      event.preventDefault?.();
      this.#end(this.#heard ? lost(event.message ?? 'no reason given') : notStarted(event.message));
    });
  }

  /**
   * @param {WebAssembly.Module} module
   * @param {Record<string, unknown>} parameters
   */
  create(module, parameters) {
    return this.#request('create', { module, parameters });
  }

  /** @param {import('./frames.js').RawFrame} frame */
  push(frame) {
    return this.#request('push', frame);
  }

  /** @param {import('./frames.js').RawFrame} frame */
  pushInShot(frame) {
    return this.#request('pushInShot', frame);
  }

  /** @param {number} overlap */
  advance(overlap) {
    return this.#request('advance', overlap);
  }

  /** @param {import('./trajectories.js').RawTrajectories} trajectories */
  setTrajectories(trajectories) {
    return this.#request('setTrajectories', trajectories);
  }

  /** @param {import('./correction.js').RawCorrection} correction */
  correct(correction) {
    return this.#request('correct', correction);
  }

  /** @param {number} t */
  flow(t) {
    return this.#request('flow', t);
  }

  /** @param {number} t */
  boundaries(t) {
    return this.#request('boundaries', t);
  }

  /** @param {number} t */
  superpixels(t) {
    return this.#request('superpixels', t);
  }

  /** @param {number} t */
  saliencyMap(t) {
    return this.#request('saliencyMap', t);
  }

  /** @param {import('./frames.js').RawFrame} image */
  boundariesOf(image) {
    return this.#request('boundariesOf', image);
  }

  /**
   * @param {import('./frames.js').RawFrame} image
   * @param {number} [count]
   */
  superpixelsOf(image, count) {
    return this.#request('superpixelsOf', { image, count });
  }

  /** @param {import('./frames.js').RawFrame} image */
  discontinuitiesOf(image) {
    return this.#request('discontinuitiesOf', image);
  }

  clear() {
    return this.#request('clear');
  }

  /**
   * @param {(progress: import('./engine.js').Progress) => void} onProgress
   * @param {AbortSignal} signal
   */
  async run(onProgress, signal) {
    const id = this.#nextId;
    const abort = () => this.#worker.postMessage({ id, type: 'abort' });
    const running = this.#request('run', undefined, onProgress);
    signal.addEventListener('abort', abort);
    try {
      return await running;
    } finally {
      signal.removeEventListener('abort', abort);
    }
  }

  close() {
    this.#end(new TraceCutError('closed', 'the session was closed'));
  }

  /**
   * @param {RequestType} type
   * @param {unknown} [data]
   * @param {Pending['onProgress']} [onProgress]
   * @returns {Promise<any>}
   */
  #request(type, data, onProgress) {
    if (this.#ended) return Promise.reject(this.#ended);
    const id = this.#nextId++;
    return new Promise((resolve, reject) => {
      this.#pending.set(id, { resolve, reject, onProgress });
      this.#worker.postMessage({ id, type, data }, transferables(data));
    });
  }

  /** @param {import('./protocol.js').Reply} reply */
  #receive({ id, type, data }) {
    this.#heard = true;
    const pending = this.#pending.get(id);
    if (!pending) return;
    if (type === 'progress') {
      pending.onProgress?.(data);
      return;
    }
    this.#pending.delete(id);
    if (type === 'done') {
      pending.resolve(data);
      return;
    }
    const error = new TraceCutError(data.code, data.message);
    pending.reject(error);
    if (error.code === 'poisoned') this.#end(error);
  }

  /**
   * Ends the worker, which frees its memory, and rejects whatever still waits for it.
   * @param {TraceCutError} reason
   */
  #end(reason) {
    if (this.#ended) return;
    this.#ended = reason;
    this.#worker.terminate();
    for (const { reject } of this.#pending.values()) reject(reason);
    this.#pending.clear();
  }
}

/** @param {string} words */
function lost(words) {
  return new TraceCutError('poisoned', `the worker stopped on an internal error: ${words}. Create a new session.`);
}

/** @param {string | undefined} words */
function notStarted(words) {
  return new TraceCutError(
    'wasm-load',
    `the worker could not be started${words ? ` (${words})` : ''}; check that worker.js and the files beside it are served as JavaScript`,
  );
}
