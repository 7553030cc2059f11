// How many threads, and when they are started.

/** Most threads that are taken without being asked for: further ones have little left to do. */
const MOST = 8;

/**
 * How many threads to work on where nobody says: all but one of the machine's.
 * @param {number | undefined} cores as many as the machine runs at once, where known
 */
export function usualThreads(cores) {
  return Math.min(MOST, Math.max(1, (cores ?? 1) - 1));
}

/**
 * A helper's worker. It is listened to for one thing: that it is no more.
 * @typedef {object} HelperWorker
 * @property {(onLost: () => void) => void} watch
 * @property {() => void} end
 */

/** Helpers of an engine: started when there is something to help with, replaced when they die, ended with the engine. */
export class Crew {
  #count;
  #start;
  #join;
  #lose;
  /** @type {Map<number, HelperWorker>} */
  #workers = new Map();
  #next = 0;
  /** Helpers that may still be replaced: one that dies again and again is given up. */
  #spare;

  /**
   * @param {number} count
   * @param {(port: MessagePort) => HelperWorker} start starts a worker that helps at the other end of `port`
   * @param {(number: number, port: MessagePort) => void} join tells the engine of a helper
   * @param {(number: number) => void} lose tells it that one is no more
   */
  constructor(count, start, join, lose) {
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

  /** Ends all for good. */
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
