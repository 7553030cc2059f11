// What changes masks: painting, carrying along, smoothing, their edges and size; and projects, which keep the changes.

import { part } from './places.js';

export { enlargeMask } from './edit/enlarge.js';
export { adjustMask } from './edit/adjust.js';
export { divideRegions, pieceRegion } from './edit/regions.js';
export { MaskEditor, editMasks } from './edit/editor.js';
export { regionOf, strokeRegion } from './edit/regions.js';

// These are loaded when they are first called.
/** @type {typeof import('./edit/carry.js').carryEdit} */
export const carryEdit = async (...args) => (await part(import('./edit/carry.js'))).carryEdit(...args);
/** @type {typeof import('./edit/grow.js').grownRegions} */
export const grownRegions = async (...args) => (await part(import('./edit/grow.js'))).grownRegions(...args);
/** @type {typeof import('./edit/smooth.js').smoothMasks} */
export const smoothMasks = async (...args) => (await part(import('./edit/smooth.js'))).smoothMasks(...args);
/** @type {typeof import('./edit/at-size.js').masksAtSize} */
export const masksAtSize = async (...args) => (await part(import('./edit/at-size.js'))).masksAtSize(...args);
/** @type {typeof import('./edit/project.js').saveProject} */
export const saveProject = async (...args) => (await part(import('./edit/project.js'))).saveProject(...args);
/** @type {typeof import('./edit/project.js').openProject} */
export const openProject = async (...args) => (await part(import('./edit/project.js'))).openProject(...args);

/** @typedef {import('./edit/carry.js').CarryOptions} CarryOptions */
/** @typedef {import('./edit/carry.js').Carried} Carried */
/** @typedef {import('./edit/grow.js').Grounds} Grounds */
/** @typedef {import('./edit/editor.js').Edit} Edit */
/** @typedef {import('./edit/editor.js').SavedEdits} SavedEdits */
/** @typedef {import('./edit/smooth.js').SmoothMasksOptions} SmoothMasksOptions */
/** @typedef {import('./edit/regions.js').BrushStroke} BrushStroke */
/** @typedef {import('./edit/regions.js').Region} Region */
/** @typedef {import('./edit/adjust.js').AdjustMaskOptions} AdjustMaskOptions */
/** @typedef {import('./edit/adjust.js').MaskEdges} MaskEdges */
/** @typedef {import('./edit/at-size.js').MasksAtSizeOptions} MasksAtSizeOptions */
/** @typedef {import('./worker/decode.js').EnlargedMask} EnlargedMask */
/** @typedef {import('./edit/enlarge.js').EnlargeOptions} EnlargeOptions */
/** @typedef {import('./edit/enlarge.js').FrameMask} FrameMask */
/** @typedef {import('./edit/project.js').Project} Project */
/** @typedef {import('./edit/project.js').ProjectOptions} ProjectOptions */
