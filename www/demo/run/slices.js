/** Work in slices: in between, the page answers whoever asks. @module */

/** How long a slice may last, in milliseconds, before others get their turn. */
const SLICE_MS = 12;

/** Resolves when others have had their turn. */
export function turn() {
  return new Promise((/** @type {(value: void) => void} */ done) => setTimeout(done));
}

/**
 * Goes on with the work to its end, step by step.
 *
 * @param {Iterator<unknown>} work
 */
export async function inSlices(work) {
  let until = performance.now() + SLICE_MS;
  while (!work.next().done) {
    if (performance.now() < until) continue;
    await turn();
    until = performance.now() + SLICE_MS;
  }
}
