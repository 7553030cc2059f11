// Ways for work to let others run: a pause for the page's thread, an end by a signal, and a halt.

export function yieldThread() {
  return new Promise<void>((resolve) => setTimeout(resolve));
}

/** Settles as the promise, or rejects with the signal's reason if that aborts first. */
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
  /** Aborted by each halt, and by the end; replaced when the work continues. */
  #halt = new AbortController();
  /** Resolved when the work continues; null while it is not halted. */
  #gate: { promise: Promise<void>; open: () => void } | null = null;

  /** Signal that the next halt aborts. */
  get signal(): AbortSignal {
    return this.#halt.signal;
  }

  get isHalted() {
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

  /** Ends the work for good: aborts the signal. */
  close() {
    this.#halt.abort();
  }

  /** Waits while the work is halted. */
  async wait() {
    // It may be halted again before this continues.
    while (this.#gate) await this.#gate.promise;
  }
}
