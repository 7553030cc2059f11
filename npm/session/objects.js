// Masks as runs of equal labels, a clip's in a few bytes a row, and what is known of each object from its pixels.

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

/** @param {readonly Uint32Array[]} parts */
export function joinedWords(parts) {
  const words = new Uint32Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    words.set(part, at);
    at += part.length;
  }
  return words;
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

/**
 * An object: its label in the masks, the first and last frame it is in, the number of frames it is in, its mean area over
 * these in pixels, and its area in each frame.
 * @typedef {{readonly label: number, readonly firstFrame: number, readonly lastFrame: number, readonly frames: number,
 *   readonly meanArea: number, readonly areas: Uint32Array<ArrayBuffer>}} VideoObject
 */

/**
 * The objects of a result, one each, by their labels, lowest first: `length` is their number. Labels have gaps in later
 * windows of a long clip and after corrections.
 * @typedef {readonly VideoObject[]} ObjectList
 */

/**
 * The pixels of an object in each frame.
 * @typedef {{readonly label: number, readonly areas: Uint32Array<ArrayBuffer>}} Areas
 */

/**
 * Lists the objects that have a pixel in some frame.
 * @param {readonly Areas[]} objects
 * @returns {ObjectList}
 */
export function objectList(objects) {
  return objects
    .filter(({ areas }) => areas.some((area) => area > 0))
    .sort((a, b) => a.label - b.label)
    .map(({ label, areas }) => ({ label, ...presence(areas), areas }));
}

/** @param {Uint32Array} areas */
function presence(areas) {
  const present = [...areas.keys()].filter((t) => areas[t]);
  const sum = areas.reduce((total, area) => total + area, 0);
  return {
    firstFrame: Number(present[0]),
    lastFrame: Number(present[present.length - 1]),
    frames: present.length,
    meanArea: sum / present.length,
  };
}
