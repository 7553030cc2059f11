// Helpers do jobs of a run, such as a frame pair or the superpixels of a frame. Each is a worker with its own instance; jobs
// and their results are exchanged as arrays of words. The session does the jobs that never return itself, so helpers may be
// slow, fail or die. A `WorkerPool` starts them, a `Pool` gives them jobs.

import type { Session as WasmSession } from '../tracecut.js';

/** Most threads by default: further ones have little left to do. */
const MAX_DEFAULT_THREADS = 8;

/**
 * Returns the default number of threads: all but one of the machine's, but both of two, as a page's thread mostly waits.
 * @param cores number of threads that the machine runs at once, if known
 */
export function defaultThreads(cores: number = 1) {
  return Math.min(MAX_DEFAULT_THREADS, Math.max(Math.min(2, cores), cores - 1));
}

/** A helper's worker; `watch` calls `onLost` when it has ended. */
export interface HelperWorker {
  watch: (onLost: () => void) => void;
  end: () => void;
}

/** Helpers of an engine: started when there are jobs, replaced when they die, ended with the engine. */
export class WorkerPool {
  #count;
  #start;
  #join;
  #lose;
  #workers = new Map<number, HelperWorker>();
  #next = 0;
  /** Number of replacements left: a helper that dies again and again is given up. */
  #replacementsLeft;

  /**
   * @param start starts a worker that helps at the other end of `port`
   * @param join adds a helper to the engine
   * @param lose removes a helper that has ended
   */
  constructor(
    count: number,
    start: (port: MessagePort) => HelperWorker,
    join: (number: number, port: MessagePort) => void,
    lose: (number: number) => void,
  ) {
    this.#count = count;
    this.#start = start;
    this.#join = join;
    this.#lose = lose;
    this.#replacementsLeft = count;
  }

  /** Starts the helpers that are missing. */
  startMissing() {
    while (this.#workers.size < this.#count) this.#add();
  }

  /** Ends all helpers until the next `startMissing`, which frees their memory. */
  rest() {
    for (const [number, worker] of this.#workers) {
      worker.end();
      this.#lose(number);
    }
    this.#workers.clear();
  }

  dismiss() {
    this.#count = 0;
    for (const worker of this.#workers.values()) worker.end();
    this.#workers.clear();
  }

  #add() {
    const number = this.#next++;
    const { port1, port2 } = new MessageChannel();
    let worker;
    try {
      worker = this.#start(port1);
    } catch {
      // No worker can start here: the engine works alone.
      this.#count = this.#workers.size;
      return;
    }
    this.#workers.set(number, worker);
    worker.watch(() => {
      if (!this.#workers.delete(number)) return;
      worker.end();
      this.#lose(number);
      if (this.#replacementsLeft-- > 0) this.startMissing();
      else this.#count = this.#workers.size;
    });
    this.#join(number, port2);
  }
}

/** Jobs of a helper at a time: the present one and two more, as this thread hears of results only between its own jobs. */
const JOBS_PER_HELPER = 3;
/** Frame pairs for each helper whose flow may be computed before it is used, which takes memory. */
const PAIRS_PER_HELPER = 2;
/** Words that identify a job. */
const HEAD_WORDS = 3;

/** One end of a channel to a helper; `MessagePort`s of browsers and of Node fit. */
export interface HelperPort {
  postMessage: (words: Uint32Array, transfer: ArrayBuffer[]) => void;
  addEventListener: (type: 'message', listener: (event: { data: unknown }) => void) => void;
  start: () => void;
  close: () => void;
  /** In Node: keeps the process alive. */
  ref?: () => void;
  /** In Node: undoes `ref`. */
  unref?: () => void;
}

interface Helper {
  port: HelperPort;
  /** Heads of the jobs that it has. */
  heads: Uint32Array[];
}

/** Exchanges jobs between a session and its helpers. */
export class Pool {
  #helpers = new Map<number, Helper>();
  #results: Uint32Array[] = [];
  /** Heads of lost jobs. */
  #lost: Uint32Array[] = [];
  #wake: (() => void) | undefined;

  /** Adds the helper with this number at the other end of `port`. */
  add(number: number, port: HelperPort) {
    const helper: Helper = { port, heads: [] };
    this.#helpers.set(number, helper);
    port.addEventListener('message', ({ data }) => {
      const head = helper.heads.shift();
      if (data instanceof Uint32Array && data.length > 0) this.#results.push(data);
      else if (head) this.#lost.push(head);
      this.#wake?.();
    });
    port.start();
    // A session that was never closed must not keep the process alive.
    port.unref?.();
  }

  /** Removes a helper that has ended. */
  lose(number: number) {
    const helper = this.#helpers.get(number);
    if (!helper) return;
    this.#helpers.delete(number);
    helper.port.close();
    this.#lost.push(...helper.heads);
    this.#wake?.();
  }

  /** True if any helper has a job, or a result has arrived. */
  get busy() {
    return this.#results.length > 0 || [...this.#helpers.values()].some(({ heads: inHand }) => inHand.length > 0);
  }

  /** Number of frame pairs whose flow may be computed before it is used. */
  get ahead() {
    return PAIRS_PER_HELPER * this.#helpers.size + 2;
  }

  /** Passes results to the session and jobs to the helpers. */
  exchange(session: WasmSession) {
    for (const head of this.#lost.splice(0)) session.release(head);
    for (const result of this.#results.splice(0)) session.accept(result);
    // Every helper gets its first job before any gets its second.
    for (let limit = 1; limit <= JOBS_PER_HELPER; limit += 1) {
      for (const { port, heads: inHand } of this.#helpers.values()) {
        if (inHand.length >= limit) continue;
        const job = session.takePiece(this.ahead);
        if (!job) return;
        inHand.push(job.slice(0, HEAD_WORDS));
        port.postMessage(job, [job.buffer as ArrayBuffer]);
      }
    }
  }

  /** Resolves when a helper has sent a result, or was lost. */
  async next() {
    if (this.#results.length > 0 || this.#lost.length > 0) return;
    for (const { port } of this.#helpers.values()) port.ref?.();
    await new Promise((resolve: (value: void) => void) => (this.#wake = resolve));
    this.#wake = undefined;
    for (const { port } of this.#helpers.values()) port.unref?.();
  }

  wake() {
    this.#wake?.();
  }

  close() {
    for (const { port } of this.#helpers.values()) port.close();
    this.#helpers.clear();
    this.#wake?.();
  }
}
