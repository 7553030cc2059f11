// Editing masks: painting, carrying, smoothing, their edges and size; and projects, which save the changes.

import { loadPart } from './platform.js';

export { enlargeMask } from './kit/edit/enlarge.js';
export { adjustMask } from './kit/edit/adjust.js';
export { MaskEditor, editMasks } from './kit/edit/editor.js';
export { decodeRuns, encodeRuns } from './session/serialize.js';

// These are loaded on their first call.
export const growRegions: typeof import('./kit/edit/grow-regions.js').growRegions = async (...args) =>
  (await loadPart(import('./kit/edit/grow-regions.js'))).growRegions(...args);
export const smoothMasks: typeof import('./kit/edit/smooth.js').smoothMasks = async (...args) =>
  (await loadPart(import('./kit/edit/smooth.js'))).smoothMasks(...args);
export const masksAtSize: typeof import('./kit/edit/at-size.js').masksAtSize = async (...args) =>
  (await loadPart(import('./kit/edit/at-size.js'))).masksAtSize(...args);
export const saveProject: typeof import('./kit/edit/project.js').saveProject = async (...args) =>
  (await loadPart(import('./kit/edit/project.js'))).saveProject(...args);
export const openProject: typeof import('./kit/edit/project.js').openProject = async (...args) =>
  (await loadPart(import('./kit/edit/project.js'))).openProject(...args);

export type { AdjustMaskOptions, MaskEdges } from './kit/edit/adjust.js';
export type { MasksAtSizeOptions } from './kit/edit/at-size.js';
export type { CarryOptions, CarryRange } from './kit/edit/carry.js';
export type { Correction, Edit, EditOptions, SavedEdits } from './kit/edit/editor.js';
export type { EnlargeOptions, FrameMask } from './kit/edit/enlarge.js';
export type { FrameFeatures } from './kit/edit/grow-regions.js';
export type { Project, ProjectOptions } from './kit/edit/project.js';
export type { SmoothMasksOptions } from './kit/edit/smooth.js';
export type { Runs as Region } from './session/serialize.js';
export type { EnlargedMask } from './worker/instance.js';
