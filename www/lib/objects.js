// What is known of each object of a clip from its pixels; the same of every result.

/**
 * An object: its label in the masks, the first and last frame it is in, the number of frames it is in, its mean area over
 * these in pixels, and its area in each frame. Where it is in no frame, `frames`, `firstFrame` and `lastFrame` are 0.
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
 * @param {readonly Areas[]} objects
 * @returns {ObjectList}
 */
export function objectList(objects) {
  return [...objects]
    .sort((a, b) => a.label - b.label)
    .map(({ label, areas }) => ({ label, ...presence(areas), areas }));
}

/** @param {Uint32Array} areas */
function presence(areas) {
  const present = [...areas.keys()].filter((t) => areas[t]);
  const sum = areas.reduce((total, area) => total + area, 0);
  return {
    firstFrame: present[0] ?? 0,
    lastFrame: present[present.length - 1] ?? 0,
    frames: present.length,
    meanArea: sum / Math.max(1, present.length),
  };
}
