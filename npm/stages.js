// Stages of the method without a session: flow, trajectories, boundaries and superpixels of images, and track files.

import { part } from './places.js';

export {
  EdgeKind,
  ImageEngine,
  boundaries,
  createImageEngine,
  flow,
  imageDiscontinuities,
  superpixels,
} from './stages/image.js';
export { sceneMotion } from './session/report.js';
export { tracksDat } from './session/report.js';

// These are loaded when they are first called.
/** @type {typeof import('./stages/tracking.js').trajectories} */
export const trajectories = async (...args) => (await part(import('./stages/tracking.js'))).trajectories(...args);
/** @type {typeof import('./stages/tracking.js').fromTracksDat} */
export const fromTracksDat = async (...args) => (await part(import('./stages/tracking.js'))).fromTracksDat(...args);

/** @typedef {import('./stages/image.js').ImageOptions} ImageOptions */
/** @typedef {import('./stages/image.js').Grid} Grid */
/** @typedef {import('./stages/image.js').SuperpixelBorders} SuperpixelBorders */
/** @typedef {import('./stages/image.js').SuperpixelCount} SuperpixelCount */
/** @typedef {import('./stages/image.js').SuperpixelEdges} SuperpixelEdges */
/** @typedef {import('./stages/image.js').SuperpixelOptions} SuperpixelOptions */
/** @typedef {import('./stages/image.js').DiscontinuityOptions} DiscontinuityOptions */
/** @typedef {import('./stages/image.js').FlowOptions} FlowOptions */
/** @typedef {import('./stages/image.js').ImageEngineOptions} ImageEngineOptions */
/** @typedef {import('./stages/image.js').ImageDiscontinuities} ImageDiscontinuities */
/** @typedef {import('./session/report.js').LabelledTrajectories} LabelledTrajectories */
/** @typedef {import('./session/report.js').SceneMotion} SceneMotion */
/** @typedef {import('./stages/tracking.js').TrackedClip} TrackedClip */
/** @typedef {import('./stages/tracking.js').TrajectoryOptions} TrajectoryOptions */
/** @typedef {import('./stages/tracking.js').TrackingProgress} TrackingProgress */
/** @typedef {import('./stages/tracking.js').TrackFile} TrackFile */
/** @typedef {import('./session/report.js').TracksToWrite} TracksToWrite */
