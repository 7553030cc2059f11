// What changes masks: painting, carrying along, smoothing, their edges and size; and projects, which keep the changes.

import { part } from './places.js';

export { enlargeMask } from './kit/edit/enlarge.js';
export { adjustMask } from './kit/edit/adjust.js';
export { MaskEditor, editMasks } from './kit/edit/editor.js';
export { decodeRuns, encodeRuns } from './session/runs.js';

// These are loaded when they are first called.
export const grownRegions: typeof import('./kit/edit/grow.js').grownRegions = async (...args) =>
  (await part(import('./kit/edit/grow.js'))).grownRegions(...args);
export const smoothMasks: typeof import('./kit/edit/smooth.js').smoothMasks = async (...args) =>
  (await part(import('./kit/edit/smooth.js'))).smoothMasks(...args);
export const masksAtSize: typeof import('./kit/edit/at-size.js').masksAtSize = async (...args) =>
  (await part(import('./kit/edit/at-size.js'))).masksAtSize(...args);
export const saveProject: typeof import('./kit/edit/project.js').saveProject = async (...args) =>
  (await part(import('./kit/edit/project.js'))).saveProject(...args);
export const openProject: typeof import('./kit/edit/project.js').openProject = async (...args) =>
  (await part(import('./kit/edit/project.js'))).openProject(...args);

export type { AdjustMaskOptions, MaskEdges } from './kit/edit/adjust.js';
export type { MasksAtSizeOptions } from './kit/edit/at-size.js';
export type { Carried, CarryOptions } from './kit/edit/carry.js';
export type { Correction, Edit, EditOptions, SavedEdits } from './kit/edit/editor.js';
export type { EnlargeOptions, FrameMask } from './kit/edit/enlarge.js';
export type { Grounds } from './kit/edit/grow.js';
export type { Project, ProjectOptions } from './kit/edit/project.js';
export type { SmoothMasksOptions } from './kit/edit/smooth.js';
export type { Runs as Region } from './session/runs.js';
export type { EnlargedMask } from './worker/decode.js';
