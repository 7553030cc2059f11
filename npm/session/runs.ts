// Run lengths: labels as runs of equal pixels, row by row. A run is a 32-bit number with the label in the lowest 8 bits, the length above.

import { TraceCutError, illegal } from '../check/errors.js';

/** Labels of a frame as runs of equal pixels, row by row: the label in the lowest 8 bits, the length above. */
export type Runs = Uint32Array<ArrayBuffer>;

/** Bits of the label in a run. */
const LABEL_BITS = 8;
const NUM_LABELS = 2 ** LABEL_BITS;
/** Longest run; longer ones are split. */
const MAX_RUN = 2 ** (32 - LABEL_BITS) - 1;

/**
 * Encodes labels as runs.
 * @param labels 0 to 255, row by row
 */
export function encodeRuns(labels: ArrayLike<number>): Runs {
  const runs: number[] = [];
  for (let from = 0; from < labels.length;) {
    const label = labels[from]!;
    let to = from + 1;
    while (to < labels.length && labels[to] === label && to - from < MAX_RUN) to += 1;
    runs.push((to - from) * NUM_LABELS + label);
    from = to;
  }
  return Uint32Array.from(runs);
}

/** Decodes runs to a label for each pixel. */
export function decodeRuns(runs: Runs): Uint8Array<ArrayBuffer> {
  const labels = new Uint8Array(sumLengths(runs));
  forEachRun(runs, (label, from, to) => labels.fill(label, from, to));
  return labels;
}

/**
 * Calls `visit` with each run, in order.
 * @param visit takes the label, the run's first pixel and the one after its last
 */
export function forEachRun(runs: Runs, visit: (label: number, from: number, to: number) => void) {
  let from = 0;
  for (const run of runs) {
    const to = from + (run >>> LABEL_BITS);
    visit(run % NUM_LABELS, from, to);
    from = to;
  }
}

/**
 * Counts the pixels of each label.
 * @returns 256 numbers
 */
export function countPixels(runs: Runs): Uint32Array<ArrayBuffer> {
  const areas = new Uint32Array(NUM_LABELS);
  forEachRun(runs, (label, from, to) => (areas[label] = Number(areas[label]) + to - from));
  return areas;
}

/** Throws unless the runs cover a frame. */
export function checkRuns(name: string, runs: unknown, size: number): Runs {
  if (!(runs instanceof Uint32Array)) throw illegal('data', name, runs, 'runs of pixels, a Uint32Array');
  const covered = sumLengths(runs as Runs);
  if (covered !== size) throw new TraceCutError('data', `${name} covers ${covered} pixels (expected ${size})`);
  return runs as Runs;
}

/** Concatenates the runs of all frames, each preceded by their number. */
export function joinRuns(frames: readonly Runs[]) {
  return joinWords(frames.flatMap((runs) => [Uint32Array.of(runs.length), runs]));
}

/** Splits the runs of `joinRuns` by frame. */
export function splitRuns(words: Uint32Array, numFrames: number): Runs[] {
  let end = 0;
  return Array.from({ length: numFrames }, () => {
    const from = end + 1;
    end = from + (words[end] ?? 0);
    return words.slice(from, end);
  });
}

export function joinWords(parts: readonly Uint32Array[]) {
  const words = new Uint32Array(parts.reduce((sum, { length }) => sum + length, 0));
  let end = 0;
  for (const part of parts) {
    words.set(part, end);
    end += part.length;
  }
  return words;
}

function sumLengths(runs: Runs) {
  return runs.reduce((sum, run) => sum + (run >>> LABEL_BITS), 0);
}
