// Work that lets the page go on: in slices, and ended by a signal.

/** Settles with the promise, or rejects with the signal's reason if that comes first. */
export function untilAborted<T>(promise: Promise<T>, signal: AbortSignal): Promise<T> {
  return new Promise((resolve, reject) => {
    if (signal.aborted) return reject(signal.reason);
    signal.addEventListener('abort', () => reject(signal.reason), { once: true });
    promise.then(resolve, reject);
  });
}

/** Longest slice of work in milliseconds: less than a frame at 60 Hz. */
const SLICE_MS = 12;

/** Resolves after other tasks of the page. */
export function yieldToPage() {
  return new Promise((resolve: (value: void) => void) => setTimeout(resolve));
}

/** Runs work to its end in slices. */
export async function runInSlices(work: Iterator<unknown>) {
  let until = performance.now() + SLICE_MS;
  while (!work.next().done) {
    if (performance.now() < until) continue;
    await yieldToPage();
    until = performance.now() + SLICE_MS;
  }
}
