// Stages of the method without a session: flow, trajectories, boundaries and superpixels of images, and track files.

import { loadPart } from './platform.js';

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

// These are loaded on their first call.
export const trajectories: typeof import('./stages/tracking.js').trajectories = async (...args) =>
  (await loadPart(import('./stages/tracking.js'))).trajectories(...args);
export const fromTracksDat: typeof import('./stages/tracking.js').fromTracksDat = async (...args) =>
  (await loadPart(import('./stages/tracking.js'))).fromTracksDat(...args);

export type { LabelledTrajectories, SceneMotion, TracksToWrite } from './session/report.js';
export type {
  DiscontinuityOptions,
  FlowOptions,
  Grid,
  ImageDiscontinuities,
  ImageEngineOptions,
  ImageOptions,
  SuperpixelBorders,
  SuperpixelCount,
  SuperpixelEdges,
  SuperpixelOptions,
} from './stages/image.js';
export type { TrackFile, TrackedClip, TrackingProgress, TrajectoryOptions } from './stages/tracking.js';
