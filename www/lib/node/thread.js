// A thread of Node in the shape of a browser's worker.

import { Worker } from 'node:worker_threads';

/** @typedef {(event: any) => void} Listener */

/**
 * Starts a thread that serves a session, or helps one. It keeps the process alive only while something is asked of it:
 * a session that nobody closed does not.
 * @returns {globalThis.Worker}
 */
export function startThread() {
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
