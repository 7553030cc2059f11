// Engines: in a worker, or on this thread with helpers beside it; and workers that do what belongs to no session.

import { TraceCutError } from '../check/errors.js';
import { wayOut } from '../places.js';
import { once, platform, workerStarter } from '../platform.js';
import { type Engine, type OnProgress, type RawResult, createLocalEngine } from '../session/engine.js';
import { Crew, type HelperWorker, usualThreads } from './helpers.js';
import { type Message, type Reply, transferables } from './protocol.js';
import type { SplitOptions, WasmSource } from '../check/options.js';
import type { Answer, Arguments, RequestName } from '../session/requests.js';
import type { TrajectoryList } from '../session/result.js';

/**
 * An engine in a worker where there are workers and the options do not say otherwise (in Node where they ask for one),
 * else in this thread.
 */
export async function openEngine({ wasm, worker, threads, parameters }: SplitOptions): Promise<Engine> {
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

/** Loads the module that reads image files when the first one comes. */
export function decoderLoader(decoder?: WasmSource) {
  return once(() => platform.loadDecoder(decoder));
}

export interface Pending {
  resolve: (value: unknown) => void;
  reject: (error: unknown) => void;
  onProgress?: OnProgress;
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

/** A worker that answers requests; where it ends, what still waits rejects. */
export class RemoteWorker {
  #worker;
  #nextId = 1;
  #pending = new Map<number, Pending>();
  /** Why the worker is no more. */
  #ended: TraceCutError | undefined;
  #heard = false;

  constructor(worker: Worker) {
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

  get ended() {
    return this.#ended !== undefined;
  }

  get nextId() {
    return this.#nextId;
  }

  /** @param options all that can be is transferred if not given */
  send<T>(
    message: Message | { task: unknown },
    {
      onProgress,
      transfer = transferables(message),
    }: { onProgress?: Pending['onProgress']; transfer?: Transferable[] } = {},
  ): Promise<T> {
    if (this.#ended) return Promise.reject(this.#ended);
    const id = this.#nextId++;
    return new Promise((done, reject) => {
      const resolve = done as Pending['resolve'];
      this.#pending.set(id, { resolve, reject, onProgress });
      this.#worker.postMessage({ id, ...message }, transfer);
    });
  }

  /** Says what is not answered. */
  tell(message: { id?: number } & (Message | { type: 'abort' })) {
    if (!this.#ended) this.#worker.postMessage({ id: 0, ...message }, transferables(message));
  }

  #receive({ id, type, data }: Reply) {
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

  /** Ends the worker, which frees its memory, and rejects whatever still waits for it. */
  end(reason: TraceCutError) {
    if (this.#ended) return;
    this.#ended = reason;
    this.#worker.terminate();
    for (const { reject } of this.#pending.values()) reject(reason);
    this.#pending.clear();
  }
}

export class RemoteEngine extends RemoteWorker implements Engine {
  crew: Crew | undefined;
  #inShots = false;

  create(module: WebAssembly.Module, parameters: Record<string, unknown>) {
    return this.send({ type: 'create', data: { module, parameters } });
  }

  request<N extends RequestName>(name: N, ...args: Arguments<N>): Promise<Answer<N>> {
    if (name === 'push' || name === 'pushInShot') this.crew?.muster();
    this.#inShots ||= name === 'pushInShot';
    return this.send({ type: name, data: args });
  }

  run(onProgress: OnProgress, signal: AbortSignal) {
    return this.#work<RawResult | null>('run', onProgress, signal);
  }

  track(onProgress: OnProgress, signal: AbortSignal) {
    return this.#work<TrajectoryList | null>('track', onProgress, signal);
  }

  async #work<T>(type: 'run' | 'track', onProgress: OnProgress, signal: AbortSignal): Promise<T> {
    const id = this.nextId;
    const abort = () => this.tell({ id, type: 'abort' });
    const running: Promise<T> = this.send({ type }, { onProgress });
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

  end(reason: TraceCutError) {
    super.end(reason);
    this.crew?.dismiss();
  }
}

/** How long workers stay that have nothing to do, in milliseconds: frames of a clip come one after the other. */
const IDLE_MS = 5000;

/** Workers that do what belongs to no session, started when there is something to do and ended when they were idle. */
export class TaskWorkers {
  #most;
  #workers: { remote: RemoteWorker; underWay: number }[] = [];
  #ending: ReturnType<typeof setTimeout> | undefined;

  /** @param most how many there may be at once */
  constructor(most: () => number) {
    this.#most = most;
  }

  /**
   * Gives work to a worker that has nothing to do, a new one where all have and there may be more, else the one with the least.
   */
  async give<T>(start: () => Worker, work: (remote: RemoteWorker) => Promise<T>) {
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

  #freest(start: () => Worker) {
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

function lost(words: string) {
  const code = /memory/i.test(words) ? 'memory' : 'poisoned';
  return new TraceCutError(code, `the worker stopped on an internal error: ${words}. Create a new session.`);
}

function notStarted(words: string | undefined) {
  return new TraceCutError(
    'wasm-load',
    `the worker could not be started${words ? ` (${words})` : ''}; check that worker.js and the files beside it are served as JavaScript. ${wayOut('worker')}`,
  );
}
