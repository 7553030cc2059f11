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
} from './image.js';
export { sceneMotion } from './scene.js';
export { tracksDat } from './tracks-dat.js';

// These are loaded when they are first called.
/** @type {typeof import('./tracking.js').trajectories} */
export const trajectories = async (...args) => (await part(import('./tracking.js'))).trajectories(...args);
/** @type {typeof import('./tracks-file.js').fromTracksDat} */
export const fromTracksDat = async (...args) => (await part(import('./tracks-file.js'))).fromTracksDat(...args);

/** @typedef {import('./image.js').ImageOptions} ImageOptions */
/** @typedef {import('./image.js').SuperpixelOptions} SuperpixelOptions */
/** @typedef {import('./image.js').DiscontinuityOptions} DiscontinuityOptions */
/** @typedef {import('./image.js').FlowOptions} FlowOptions */
/** @typedef {import('./image.js').ImageEngineOptions} ImageEngineOptions */
/** @typedef {import('./image.js').ImageDiscontinuities} ImageDiscontinuities */
/** @typedef {import('./scene.js').LabelledTrajectories} LabelledTrajectories */
/** @typedef {import('./scene.js').SceneMotion} SceneMotion */
/** @typedef {import('./tracking.js').TrackedClip} TrackedClip */
/** @typedef {import('./tracking.js').TrajectoryOptions} TrajectoryOptions */
/** @typedef {import('./tracking.js').TrackingProgress} TrackingProgress */
/** @typedef {import('./tracks-file.js').TrackFile} TrackFile */
/** @typedef {import('./tracks-dat.js').TracksToWrite} TracksToWrite */
