// The objects of a result, by the pixels that they have in each frame.

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
