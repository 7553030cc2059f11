// Work that lets the page go on, in slices.

import { yieldThread } from './library.js';

/** Longest slice of work in milliseconds: less than a frame at 60 Hz. */
const SLICE_MS = 12;

/** Runs work to its end in slices. */
export async function runInSlices(work: Iterator<unknown>) {
  let until = performance.now() + SLICE_MS;
  while (!work.next().done) {
    if (performance.now() < until) continue;
    await yieldThread();
    until = performance.now() + SLICE_MS;
  }
}
