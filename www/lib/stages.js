// Stages of the method without a session: flow, trajectories, boundaries and superpixels of images, and track files.

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
export { trajectories } from './tracking.js';
export { tracksDat } from './tracks-dat.js';
export { fromTracksDat } from './tracks-file.js';

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
