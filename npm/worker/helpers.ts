// Helpers that work on pieces of a run, such as a frame pair or the superpixels of a frame. Each is a worker with an instance of
// its own; pieces and what becomes of them go to and fro as arrays of words. The session makes what never comes back by
// itself, so helpers may be slow, fail or die. A `Crew` starts them, a `Pool` gives them work.

import type { Session as WasmSession } from '../tracecut.js';

/** Most threads that are taken without being asked for: further ones have little left to do. */
const MOST = 8;

/**
 * How many threads to work on where nobody says: all but one of the machine's.
 * @param cores as many as the machine runs at once, where known
 */
export function usualThreads(cores: number | undefined) {
  return Math.min(MOST, Math.max(1, (cores ?? 1) - 1));
}

/** A helper's worker. It is listened to for one thing: that it is no more. */
export interface HelperWorker {
  watch: (onLost: () => void) => void;
  end: () => void;
}

/** Helpers of an engine: started when there is something to help with, replaced when they die, ended with the engine. */
export class Crew {
  #count;
  #start;
  #join;
  #lose;
  #workers = new Map<number, HelperWorker>();
  #next = 0;
  /** Helpers that may still be replaced: one that dies again and again is given up. */
  #spare;

  /**
   * @param start starts a worker that helps at the other end of `port`
   * @param join tells the engine of a helper
   * @param lose tells it that one is no more
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
    this.#spare = count;
  }

  /** Starts those that are missing. */
  muster() {
    while (this.#workers.size < this.#count) this.#add();
  }

  /** Ends all until the next muster: their memory is given back. */
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
      // No worker can be started here: the engine works alone.
      this.#count = this.#workers.size;
      return;
    }
    this.#workers.set(number, worker);
    worker.watch(() => {
      if (!this.#workers.delete(number)) return;
      worker.end();
      this.#lose(number);
      if (this.#spare-- > 0) this.muster();
      else this.#count = this.#workers.size;
    });
    this.#join(number, port2);
  }
}

/** Pieces that a helper has at a time: the one that it works on, and the next. */
const IN_HAND = 2;
/** Words that tell which piece it is. */
const HEAD = 3;

/** One end of a channel whose other end is a helper's; `MessagePort`s of browsers and of Node are such. */
export interface HelperPort {
  postMessage: (words: Uint32Array, transfer: ArrayBuffer[]) => void;
  addEventListener: (type: 'message', listener: (event: { data: unknown }) => void) => void;
  start: () => void;
  close: () => void;
  /** In Node: it keeps the process alive from now on. */
  ref?: () => void;
  /** In Node: it no longer does. */
  unref?: () => void;
}

interface Helper {
  port: HelperPort;
  /** Heads of the pieces that it works on. */
  inHand: Uint32Array[];
}

/** The helpers of one session. */
export class Pool {
  #helpers = new Map<number, Helper>();
  #back: Uint32Array[] = [];
  /** Heads of pieces that are lost. */
  #lost: Uint32Array[] = [];
  #wake: (() => void) | undefined;

  /** Adds the helper with this number at the other end of `port`. */
  add(number: number, port: HelperPort) {
    const helper: Helper = { port, inHand: [] };
    this.#helpers.set(number, helper);
    port.addEventListener('message', ({ data }) => {
      const head = helper.inHand.shift();
      if (data instanceof Uint32Array && data.length > 0) this.#back.push(data);
      else if (head) this.#lost.push(head);
      this.#wake?.();
    });
    port.start();
    // A session that nobody closed keeps no process alive.
    port.unref?.();
  }

  /** This helper is no more. */
  lose(number: number) {
    const helper = this.#helpers.get(number);
    if (!helper) return;
    this.#helpers.delete(number);
    helper.port.close();
    this.#lost.push(...helper.inHand);
    this.#wake?.();
  }

  /** Whether any helper has anything. */
  get busy() {
    return this.#back.length > 0 || [...this.#helpers.values()].some(({ inHand }) => inHand.length > 0);
  }

  /** For how many frame pairs flow may be made before it is used. */
  get ahead() {
    return IN_HAND * this.#helpers.size + 2;
  }

  /** Takes what is back and gives away what helpers have hands for. */
  exchange(session: WasmSession) {
    for (const head of this.#lost.splice(0)) session.release(head);
    for (const made of this.#back.splice(0)) session.accept(made);
    // The first pieces of all before the second of any.
    for (let most = 1; most <= IN_HAND; most += 1) {
      for (const { port, inHand } of this.#helpers.values()) {
        if (inHand.length >= most) continue;
        const piece = session.takePiece(this.ahead);
        if (!piece) return;
        inHand.push(piece.slice(0, HEAD));
        port.postMessage(piece, [piece.buffer as ArrayBuffer]);
      }
    }
  }

  /** Resolves when something came from a helper, or one was lost. */
  async next() {
    if (this.#back.length > 0 || this.#lost.length > 0) return;
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
