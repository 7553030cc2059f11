// What changes masks: painting, carrying along, smoothing, their edges and size; and projects, which keep the changes.

import { part } from './places.js';

export { enlargeMask } from './kit/edit/enlarge.js';
export { adjustMask } from './kit/edit/adjust.js';
export { MaskEditor, editMasks } from './kit/edit/editor.js';
export { decodeRuns, encodeRuns } from './session/runs.js';

// These are loaded when they are first called.
/** @type {typeof import('./kit/edit/grow.js').grownRegions} */
export const grownRegions = async (...args) => (await part(import('./kit/edit/grow.js'))).grownRegions(...args);
/** @type {typeof import('./kit/edit/smooth.js').smoothMasks} */
export const smoothMasks = async (...args) => (await part(import('./kit/edit/smooth.js'))).smoothMasks(...args);
/** @type {typeof import('./kit/edit/at-size.js').masksAtSize} */
export const masksAtSize = async (...args) => (await part(import('./kit/edit/at-size.js'))).masksAtSize(...args);
/** @type {typeof import('./kit/edit/project.js').saveProject} */
export const saveProject = async (...args) => (await part(import('./kit/edit/project.js'))).saveProject(...args);
/** @type {typeof import('./kit/edit/project.js').openProject} */
export const openProject = async (...args) => (await part(import('./kit/edit/project.js'))).openProject(...args);

/** @typedef {import('./kit/edit/carry.js').CarryOptions} CarryOptions */
/** @typedef {import('./kit/edit/carry.js').Carried} Carried */
/** @typedef {import('./kit/edit/grow.js').Grounds} Grounds */
/** @typedef {import('./kit/edit/editor.js').Correction} Correction */
/** @typedef {import('./kit/edit/editor.js').Edit} Edit */
/** @typedef {import('./kit/edit/editor.js').EditOptions} EditOptions */
/** @typedef {import('./kit/edit/editor.js').SavedEdits} SavedEdits */
/** @typedef {import('./kit/edit/smooth.js').SmoothMasksOptions} SmoothMasksOptions */
/** @typedef {import('./kit/edit/regions.js').Region} Region */
/** @typedef {import('./kit/edit/adjust.js').AdjustMaskOptions} AdjustMaskOptions */
/** @typedef {import('./kit/edit/adjust.js').MaskEdges} MaskEdges */
/** @typedef {import('./kit/edit/at-size.js').MasksAtSizeOptions} MasksAtSizeOptions */
/** @typedef {import('./worker/decode.js').EnlargedMask} EnlargedMask */
/** @typedef {import('./kit/edit/enlarge.js').EnlargeOptions} EnlargeOptions */
/** @typedef {import('./kit/edit/enlarge.js').FrameMask} FrameMask */
/** @typedef {import('./kit/edit/project.js').Project} Project */
/** @typedef {import('./kit/edit/project.js').ProjectOptions} ProjectOptions */
