// Engines in a worker, or on this thread with helpers beside it; and workers for tasks that belong to no session.

import { TraceCutError } from '../check/errors.js';
import { getMissingFileHint, getWorkerStarter, loadOnce, platform } from '../platform.js';
import { type Engine, type OnStep, type RawResult, createLocalEngine } from '../session/engine.js';
import { WorkerPool, type HelperWorker, defaultThreads } from './helpers.js';
import { type Message, type Reply, findTransferables } from './protocol.js';
import type { EngineOptions, WasmSource } from '../check/options.js';
import type { Answer, Arguments, RequestName } from '../session/requests.js';
import type { TrajectoryList } from '../session/result.js';

/**
 * Opens an engine in a worker if there are workers and the options do not disable them (in Node if they enable them), else
 * in this thread.
 */
export async function openEngine({ wasm, worker, threads, parameters }: EngineOptions): Promise<Engine> {
  const { loadModule, startHelper, cores } = platform;
  const start = getWorkerStarter(worker);
  const module = await loadModule(wasm);
  const defaultCount = worker === false ? 1 : defaultThreads(cores());
  if (start) return createRemoteEngine(start, module, parameters, threads ?? defaultCount);
  const engine = await createLocalEngine(module, parameters);
  if (startHelper) {
    engine.workers = new WorkerPool(
      (threads ?? defaultCount) - 1,
      (port) => startHelper({ module, parameters, port }),
      (number, port) => engine.pool.add(number, port),
      (number) => engine.pool.lose(number),
    );
  }
  return engine;
}

/** Returns a function that loads the module for image files when the first one arrives. */
export function createDecoderLoader(decoder?: WasmSource) {
  return loadOnce(() => platform.loadDecoder(decoder));
}

interface Pending {
  resolve: (value: unknown) => void;
  reject: (error: unknown) => void;
  onProgress?: OnStep;
}

export async function createRemoteEngine(
  startWorker: () => Worker,
  module: WebAssembly.Module,
  parameters: Record<string, unknown>,
  threads = 1,
) {
  const engine = new RemoteEngine(startWorker());
  try {
    await engine.create(module, parameters);
    engine.workers = new WorkerPool(
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

function startHelper(
  worker: Worker,
  data: { module: WebAssembly.Module; parameters: Record<string, unknown>; port: MessagePort },
): HelperWorker {
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

/** A worker that answers requests; when it ends, pending ones reject. */
export class RemoteWorker {
  #worker;
  #nextId = 1;
  #pending = new Map<number, Pending>();
  /** Error that ended the worker. */
  #endError: TraceCutError | undefined;
  #hasAnswered = false;

  constructor(worker: Worker) {
    this.#worker = worker;
    worker.addEventListener('message', (event) => this.#receive(event.data));
    worker.addEventListener('messageerror', () => this.end(createLostError('a message could not be read')));
    worker.addEventListener('error', (event) => {
      event.preventDefault?.();
      this.end(
        this.#hasAnswered ? createLostError(event.message ?? 'no reason given') : createStartError(event.message),
      );
    });
  }

  /** True if it has answered anything: before that it is unknown if it runs. */
  get heard() {
    return this.#hasAnswered;
  }

  get ended() {
    return this.#endError !== undefined;
  }

  get nextId() {
    return this.#nextId;
  }

  /** @param options `transfer` defaults to all that can be transferred */
  send<T>(
    message: Message | { task: unknown },
    {
      onProgress,
      transfer = findTransferables(message),
    }: { onProgress?: Pending['onProgress']; transfer?: Transferable[] } = {},
  ): Promise<T> {
    if (this.#endError) return Promise.reject(this.#endError);
    const id = this.#nextId++;
    return new Promise((resolvePromise, reject) => {
      const resolve = resolvePromise as Pending['resolve'];
      this.#pending.set(id, { resolve, reject, onProgress });
      this.#worker.postMessage({ id, ...message }, transfer);
    });
  }

  /** Sends a message that is not answered. */
  tell(message: { id?: number } & (Message | { type: 'abort' })) {
    if (!this.#endError) this.#worker.postMessage({ id: 0, ...message }, findTransferables(message));
  }

  #receive({ id, type, data }: Reply) {
    this.#hasAnswered = true;
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

  /** Ends the worker, which frees its memory, and rejects all pending requests. */
  end(reason: TraceCutError) {
    if (this.#endError) return;
    this.#endError = reason;
    this.#worker.terminate();
    for (const { reject } of this.#pending.values()) reject(reason);
    this.#pending.clear();
  }
}

export class RemoteEngine extends RemoteWorker implements Engine {
  workers: WorkerPool | undefined;
  #isWindowed = false;

  create(module: WebAssembly.Module, parameters: Record<string, unknown>) {
    return this.send({ type: 'create', data: { module, parameters } });
  }

  request<N extends RequestName>(name: N, ...args: Arguments<N>): Promise<Answer<N>> {
    if (name === 'push' || name === 'pushInShot') this.workers?.startMissing();
    this.#isWindowed ||= name === 'pushInShot';
    return this.send({ type: name, data: args });
  }

  run(onProgress: OnStep, signal: AbortSignal) {
    return this.#runUntilAborted<RawResult | null>('run', onProgress, signal);
  }

  track(onProgress: OnStep, signal: AbortSignal) {
    return this.#runUntilAborted<TrajectoryList | null>('track', onProgress, signal);
  }

  async #runUntilAborted<T>(type: 'run' | 'track', onProgress: OnStep, signal: AbortSignal): Promise<T> {
    const id = this.nextId;
    const abort = () => this.tell({ id, type: 'abort' });
    const running: Promise<T> = this.send({ type }, { onProgress });
    signal.addEventListener('abort', abort);
    try {
      const result = await running;
      // Helpers have nothing left to do, unless another window follows.
      if (result && !this.#isWindowed) this.workers?.rest();
      return result;
    } finally {
      signal.removeEventListener('abort', abort);
    }
  }

  rest() {
    this.#isWindowed = false;
    this.workers?.rest();
  }

  close() {
    this.end(new TraceCutError('closed', 'the session was closed'));
  }

  end(reason: TraceCutError) {
    super.end(reason);
    this.workers?.dismiss();
  }
}

/** Time after which idle workers end: frames of a clip follow one after the other. */
const IDLE_MS = 5000;

/** Workers for tasks that belong to no session, started on demand and ended when idle. */
export class TaskWorkers {
  #maxWorkers;
  #workers: { remote: RemoteWorker; numTasks: number }[] = [];
  #endTimer: ReturnType<typeof setTimeout> | undefined;

  /** @param maxWorkers returns the largest number of workers at once */
  constructor(maxWorkers: () => number) {
    this.#maxWorkers = maxWorkers;
  }

  /** Gives work to an idle worker; if there is none, to a new one if allowed, else to the one with the fewest tasks. */
  async give<T>(start: () => Worker, work: (remote: RemoteWorker) => Promise<T>) {
    clearTimeout(this.#endTimer);
    const entry = this.#chooseWorker(start);
    entry.numTasks += 1;
    try {
      return await work(entry.remote);
    } finally {
      entry.numTasks -= 1;
      // A worker that could not start, or was lost, is dropped.
      this.#workers = this.#workers.filter(({ remote }) => !remote.ended);
      if (this.#workers.every(({ numTasks: numTasks }) => numTasks === 0))
        this.#endTimer = setTimeout(() => this.#end(), IDLE_MS);
    }
  }

  #chooseWorker(start: () => Worker) {
    const [first] = [...this.#workers].sort((a, b) => a.numTasks - b.numTasks);
    if (first && (first.numTasks === 0 || this.#workers.length >= Math.max(1, this.#maxWorkers()))) return first;
    const added = { remote: new RemoteWorker(start()), numTasks: 0 };
    this.#workers.push(added);
    return added;
  }

  #end() {
    for (const { remote } of this.#workers) remote.end(new TraceCutError('closed', 'the worker had nothing to do'));
    this.#workers = [];
  }
}

function createLostError(reason: string) {
  const code = /memory/i.test(reason) ? 'memory' : 'poisoned';
  return new TraceCutError(code, `the worker stopped on an internal error: ${reason}. Create a new session.`);
}

function createStartError(reason: string | undefined) {
  return new TraceCutError(
    'wasm-load',
    `the worker could not be started${reason ? ` (${reason})` : ''}; check that worker.js and the files beside it are served as JavaScript. ${getMissingFileHint('worker')}`,
  );
}
