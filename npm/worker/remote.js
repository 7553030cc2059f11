// Engines: in a worker, or on this thread with helpers beside it; and workers that do what belongs to no session.

import { TraceCutError } from '../check/errors.js';
import { wayOut } from '../places.js';
import { once, platform, workerStarter } from '../platform.js';
import { createLocalEngine } from '../session/engine.js';
import { Crew, usualThreads } from './helpers.js';
import { transferables } from './protocol.js';

/**
 * An engine in a worker where there are workers and the options do not say otherwise (in Node where they ask for one),
 * else in this thread.
 * @param {import('../check/options.js').SplitOptions} options
 * @returns {Promise<import('../session/engine.js').Engine>}
 */
export async function openEngine({ wasm, worker, threads, parameters }) {
  const { loadModule, startHelper, cores } = platform;
  const start = workerStarter(worker);
  const module = await loadModule(wasm);
  const usual = worker === false ? 1 : usualThreads(cores());
  if (start) return createRemoteEngine(start, module, parameters, threads ?? usual);
  const engine = await createLocalEngine(module, parameters);
  if (startHelper) {
    engine.crew = new Crew(
      (threads ?? usual) - 1,
      (port) => startHelper({ module, parameters, port }),
      (number, port) => engine.pool.add(number, port),
      (number) => engine.pool.lose(number),
    );
  }
  return engine;
}

/**
 * Loads the module that reads image files when the first one comes.
 * @param {import('../check/options.js').WasmSource} [decoder]
 */
export function decoderLoader(decoder) {
  return once(() => platform.loadDecoder(decoder));
}

/** @typedef {import('../session/engine.js').Engine} Engine */

/**
 * @typedef {object} Pending
 * @property {(value: unknown) => void} resolve
 * @property {(error: unknown) => void} reject
 * @property {(progress: import('../session/engine.js').Progress) => void} [onProgress]
 */

/**
 * @param {() => Worker} startWorker
 * @param {WebAssembly.Module} module
 * @param {Record<string, unknown>} parameters
 * @param {number} threads
 */
export async function createRemoteEngine(startWorker, module, parameters, threads = 1) {
  const engine = new RemoteEngine(startWorker());
  try {
    await engine.create(module, parameters);
    engine.crew = new Crew(
      threads - 1,
      (port) => startHelper(startWorker(), { module, parameters, port }),
      (number, port) => engine.tell({ type: 'helper', data: { number, port } }),
      (number) => engine.tell({ type: 'lost', data: { number } }),
    );
  } catch (error) {
    engine.close();
    throw error;
  }
  return engine;
}

/**
 * @param {Worker} worker
 * @param {{module: WebAssembly.Module, parameters: Record<string, unknown>, port: MessagePort}} data
 * @returns {import('./helpers.js').HelperWorker}
 */
function startHelper(worker, data) {
  worker.postMessage({ id: 0, type: 'help', data }, [data.port]);
  return {
    watch(onLost) {
      worker.addEventListener('error', (event) => {
        event.preventDefault?.();
        onLost();
      });
    },
    end: () => worker.terminate(),
  };
}

/** A worker that answers requests; where it ends, what still waits rejects. */
export class RemoteWorker {
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
    worker.addEventListener('messageerror', () => this.end(lost('a message could not be read')));
    worker.addEventListener('error', (event) => {
      event.preventDefault?.();
      this.end(this.#heard ? lost(event.message ?? 'no reason given') : notStarted(event.message));
    });
  }

  /** Whether it has answered anything: before that nobody knows whether it runs. */
  get heard() {
    return this.#heard;
  }

  /** Whether the worker is no more. */
  get ended() {
    return this.#ended !== undefined;
  }

  /** The id of the next request. */
  get nextId() {
    return this.#nextId;
  }

  /**
   * @template T what this message is answered with
   * @param {import('./protocol.js').Message | {task: unknown}} message
   * @param {{onProgress?: Pending['onProgress'], transfer?: Transferable[]}} [options] all that can be is transferred if not given
   * @returns {Promise<T>}
   */
  send(message, { onProgress, transfer = transferables(message) } = {}) {
    if (this.#ended) return Promise.reject(this.#ended);
    const id = this.#nextId++;
    return new Promise((done, reject) => {
      const resolve = /** @type {Pending['resolve']} */ (done);
      this.#pending.set(id, { resolve, reject, onProgress });
      this.#worker.postMessage({ id, ...message }, transfer);
    });
  }

  /**
   * Says what is not answered.
   * @param {{id?: number} & (import('./protocol.js').Message | {type: 'abort'})} message
   */
  tell(message) {
    if (!this.#ended) this.#worker.postMessage({ id: 0, ...message }, transferables(message));
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
    if (error.code === 'poisoned' || error.code === 'memory') this.end(error);
  }

  /**
   * Ends the worker, which frees its memory, and rejects whatever still waits for it.
   * @param {TraceCutError} reason
   */
  end(reason) {
    if (this.#ended) return;
    this.#ended = reason;
    this.#worker.terminate();
    for (const { reject } of this.#pending.values()) reject(reason);
    this.#pending.clear();
  }
}

/** @implements {Engine} */
export class RemoteEngine extends RemoteWorker {
  /** @type {Crew | undefined} */
  crew;
  #inShots = false;

  /**
   * @param {WebAssembly.Module} module
   * @param {Record<string, unknown>} parameters
   */
  create(module, parameters) {
    return this.send({ type: 'create', data: { module, parameters } });
  }

  /**
   * @template {import('../session/requests.js').RequestName} N
   * @param {N} name
   * @param {import('../session/requests.js').Arguments<N>} args
   * @returns {Promise<import('../session/requests.js').Answer<N>>}
   */
  request(name, ...args) {
    if (name === 'push' || name === 'pushInShot') this.crew?.muster();
    this.#inShots ||= name === 'pushInShot';
    return this.send({ type: name, data: args });
  }

  /** @type {Engine['run']} */
  run(onProgress, signal) {
    return this.#work('run', onProgress, signal);
  }

  /** @type {Engine['track']} */
  track(onProgress, signal) {
    return this.#work('track', onProgress, signal);
  }

  /**
   * @template T what a run of this type is answered with
   * @param {'run' | 'track'} type
   * @param {(progress: import('../session/engine.js').Progress) => void} onProgress
   * @param {AbortSignal} signal
   * @returns {Promise<T>}
   */
  async #work(type, onProgress, signal) {
    const id = this.nextId;
    const abort = () => this.tell({ id, type: 'abort' });
    /** @type {Promise<T>} */
    const running = this.send({ type }, { onProgress });
    signal.addEventListener('abort', abort);
    try {
      const result = await running;
      // Helpers have nothing left to do, unless there is another window.
      if (result && !this.#inShots) this.crew?.rest();
      return result;
    } finally {
      signal.removeEventListener('abort', abort);
    }
  }

  rest() {
    this.#inShots = false;
    this.crew?.rest();
  }

  close() {
    this.end(new TraceCutError('closed', 'the session was closed'));
  }

  /** @param {TraceCutError} reason */
  end(reason) {
    super.end(reason);
    this.crew?.dismiss();
  }
}

/** How long workers stay that have nothing to do, in milliseconds: frames of a clip come one after the other. */
const IDLE_MS = 5000;

/** Workers that do what belongs to no session, started when there is something to do and ended when they were idle. */
export class TaskWorkers {
  #most;
  /** @type {{remote: RemoteWorker, underWay: number}[]} */
  #workers = [];
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #ending;

  /** @param {() => number} most how many there may be at once */
  constructor(most) {
    this.#most = most;
  }

  /**
   * Gives work to a worker that has nothing to do, a new one where all have and there may be more, else the one with the least.
   * @template T
   * @param {() => Worker} start
   * @param {(remote: RemoteWorker) => Promise<T>} work
   */
  async give(start, work) {
    clearTimeout(this.#ending);
    const mine = this.#freest(start);
    mine.underWay += 1;
    try {
      return await work(mine.remote);
    } finally {
      mine.underWay -= 1;
      // One that could not start, or was lost, is of no more use.
      this.#workers = this.#workers.filter(({ remote }) => !remote.ended);
      if (this.#workers.every(({ underWay }) => underWay === 0)) this.#ending = setTimeout(() => this.#end(), IDLE_MS);
    }
  }

  /** @param {() => Worker} start */
  #freest(start) {
    const [first] = [...this.#workers].sort((a, b) => a.underWay - b.underWay);
    if (first && (first.underWay === 0 || this.#workers.length >= Math.max(1, this.#most()))) return first;
    const added = { remote: new RemoteWorker(start()), underWay: 0 };
    this.#workers.push(added);
    return added;
  }

  #end() {
    for (const { remote } of this.#workers) remote.end(new TraceCutError('closed', 'the worker had nothing to do'));
    this.#workers = [];
  }
}

/** @param {string} words */
function lost(words) {
  const code = /memory/i.test(words) ? 'memory' : 'poisoned';
  return new TraceCutError(code, `the worker stopped on an internal error: ${words}. Create a new session.`);
}

/** @param {string | undefined} words */
function notStarted(words) {
  return new TraceCutError(
    'wasm-load',
    `the worker could not be started${words ? ` (${words})` : ''}; check that worker.js and the files beside it are served as JavaScript. ${wayOut('worker')}`,
  );
}
