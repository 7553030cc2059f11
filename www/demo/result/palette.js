/** Colours, shapes and names of objects: the package's, and what only the page needs. @module */

export { CUT_RED, EDGE_STYLES, flowColor, heatColor, objectColor, objectShape } from '../../dist/index.js';

/** @typedef {import('../../dist/index.js').Shape} Shape */

/** Points that are there but not meant. */
export const FAINT = 'rgb(255 255 255 / 0.45)';

/**
 * @param {number} object
 * @returns {string}
 */
export function objectName(object) {
  return object === 0 ? 'Background' : `Object ${object}`;
}
