// What changes masks: painting, carrying along, smoothing, their edges and size; and projects, which keep the changes.

import { part } from './places.js';

export { enlargeMask } from './enlarge.js';
export { adjustMask } from './export/adjust.js';
export { divideRegions, pieceRegion } from './edit/divide.js';
export { MaskEditor, editMasks } from './edit/editor.js';
export { regionOf, strokeRegion } from './edit/regions.js';

// These are loaded when they are first called.
/** @type {typeof import('./edit/carry.js').carryEdit} */
export const carryEdit = async (...args) => (await part(import('./edit/carry.js'))).carryEdit(...args);
/** @type {typeof import('./edit/smooth.js').smoothMasks} */
export const smoothMasks = async (...args) => (await part(import('./edit/smooth.js'))).smoothMasks(...args);
/** @type {typeof import('./export/at-size.js').masksAtSize} */
export const masksAtSize = async (...args) => (await part(import('./export/at-size.js'))).masksAtSize(...args);
/** @type {typeof import('./export/project.js').saveProject} */
export const saveProject = async (...args) => (await part(import('./export/project.js'))).saveProject(...args);
/** @type {typeof import('./export/project.js').openProject} */
export const openProject = async (...args) => (await part(import('./export/project.js'))).openProject(...args);

/** @typedef {import('./edit/carry.js').CarryOptions} CarryOptions */
/** @typedef {import('./edit/editor.js').Edit} Edit */
/** @typedef {import('./edit/editor.js').SavedEdits} SavedEdits */
/** @typedef {import('./edit/smooth.js').SmoothMasksOptions} SmoothMasksOptions */
/** @typedef {import('./edit/regions.js').BrushStroke} BrushStroke */
/** @typedef {import('./edit/regions.js').Region} Region */
/** @typedef {import('./export/adjust.js').AdjustMaskOptions} AdjustMaskOptions */
/** @typedef {import('./export/adjust.js').MaskEdges} MaskEdges */
/** @typedef {import('./export/at-size.js').MasksAtSizeOptions} MasksAtSizeOptions */
/** @typedef {import('./enlarge-here.js').EnlargedMask} EnlargedMask */
/** @typedef {import('./enlarge.js').EnlargeOptions} EnlargeOptions */
/** @typedef {import('./enlarge.js').FrameMask} FrameMask */
/** @typedef {import('./export/project.js').Project} Project */
/** @typedef {import('./export/project.js').ProjectOptions} ProjectOptions */
