/** The edges of masks as they are wanted. @module */

/**
 * The smallest piece that counts, in percent of the frame; how far objects grow, or shrink where it is negative, and how
 * soft their edges are, in pixels of the masks; over how many frames before and after they are smoothed.
 *
 * @typedef {{smallest: number, grow: number, feather: number, smooth: number}} EdgeChoice
 */

/** Specks are nobody's wish. @type {EdgeChoice} */
export const DEFAULT_EDGES = { smallest: 0.02, grow: 0, feather: 0, smooth: 0 };

/**
 * @param {EdgeChoice} choice
 * @param {{width: number, height: number}} size of the masks
 * @returns {import('../../dist/edit.js').MaskEdges} as the package takes it
 */
export function edgesOf({ smallest, grow, feather }, { width, height }) {
  return { smallest: Math.ceil((smallest / 100) * width * height), grow, feather };
}
