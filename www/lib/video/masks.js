// Label maps as runs of equal labels: a clip's masks in a few bytes a row.

/** Runs are numbers of 32 bits: the label in the lowest 8, the length above. */
const LABEL_BITS = 8;
const MAX_RUN = 2 ** (32 - LABEL_BITS) - 1;

/** Labels that are called as they are. */
export const IDENTITY = Uint8Array.from({ length: 256 }, (_, label) => label);

/**
 * @param {Uint8Array} labels
 * @returns {Uint32Array<ArrayBuffer>}
 */
export function encodeRuns(labels) {
  /** @type {number[]} */
  const runs = [];
  for (let from = 0; from < labels.length;) {
    const label = /** @type {number} */ (labels[from]);
    let to = from + 1;
    while (to < labels.length && labels[to] === label && to - from < MAX_RUN) to += 1;
    runs.push((to - from) * 2 ** LABEL_BITS + label);
    from = to;
  }
  return Uint32Array.from(runs);
}

/**
 * @param {Uint32Array} runs
 * @param {number} size number of pixels
 * @param {Uint8Array} table what each label is called now
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function decodeRuns(runs, size, table) {
  const labels = new Uint8Array(size);
  let at = 0;
  for (const run of runs) {
    const length = run >>> LABEL_BITS;
    labels.fill(/** @type {number} */ (table[run & 255]), at, at + length);
    at += length;
  }
  return labels;
}

/**
 * How many pixels each label has, without decoding.
 * @param {Uint32Array} runs
 * @returns {Uint32Array<ArrayBuffer>} 256 numbers
 */
export function areasOf(runs) {
  const areas = new Uint32Array(256);
  for (const run of runs) areas[run & 255] = /** @type {number} */ (areas[run & 255]) + (run >>> LABEL_BITS);
  return areas;
}
