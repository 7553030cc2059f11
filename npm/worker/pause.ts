// How work lets others go first: a breath for the page's thread, an end by a signal, and a halt that it can be put on.

export function breath() {
  return new Promise<void>((done) => setTimeout(done));
}

/** Settles as the promise does, or rejects with the signal's reason if that aborts first. */
export function untilAborted<T>(promise: Promise<T>, signal: AbortSignal | undefined): Promise<T> {
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
  /** Closed while the work is halted. */
  #gate: { promise: Promise<void>; open: () => void } | null = null;

  /** For what stops by a signal: aborted by the next halt. */
  get signal(): AbortSignal {
    return this.#halt.signal;
  }

  get on() {
    return this.#gate !== null;
  }

  begin() {
    if (this.#gate) return;
    let open = () => {};
    const promise = new Promise((done: (value: void) => void) => (open = done));
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
