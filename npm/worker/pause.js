// How work lets others go first: a breath for the page's thread, an end by a signal, and a halt that it can be put on.

export function breath() {
  return new Promise((done) => setTimeout(done));
}

/**
 * Settles as the promise does, or rejects with the signal's reason if that aborts first.
 * @template T
 * @param {Promise<T>} promise
 * @param {AbortSignal | undefined} signal
 * @returns {Promise<T>}
 */
export function untilAborted(promise, signal) {
  if (!signal) return promise;
  return new Promise((resolve, reject) => {
    const abort = () => reject(signal.reason);
    if (signal.aborted) abort();
    signal.addEventListener('abort', abort, { once: true });
    promise.then(resolve, reject).finally(() => signal.removeEventListener('abort', abort));
  });
}

export class Pause {
  /** Aborted by each halt, and by the end; a new one follows when the work goes on. */
  #halt = new AbortController();
  /** @type {{promise: Promise<void>, open: () => void} | null} Closed while the work is halted. */
  #gate = null;

  /** For what stops by a signal: aborted by the next halt. @returns {AbortSignal} */
  get signal() {
    return this.#halt.signal;
  }

  /** Whether the work is halted. */
  get on() {
    return this.#gate !== null;
  }

  begin() {
    if (this.#gate) return;
    let open = () => {};
    const promise = new Promise((/** @type {(value: void) => void} */ done) => (open = done));
    this.#gate = { promise, open };
    this.#halt.abort();
  }

  end() {
    if (!this.#gate) return;
    this.#halt = new AbortController();
    this.#gate.open();
    this.#gate = null;
  }

  /** The work is over for good: what stops by the signal stops. */
  close() {
    this.#halt.abort();
  }

  /** Waits at the gate while the work is halted. */
  async passed() {
    // It may be halted again before whoever waited is told.
    while (this.#gate) await this.#gate.promise;
  }
}
