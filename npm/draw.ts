// Drawing over frames: trajectories, superpixels, maps, cut-out objects. `drawLabels` is in the root entry.

export { fitFrame } from './draw/canvas.js';
export { drawCutout } from './draw/cutout.js';
export { drawDiscontinuities } from './draw/maps.js';
export { drawBoundaries, drawCells, drawFlow, drawSaliency } from './draw/maps.js';
export { CUT_RED, SCREEN_GREEN, flowColor, heatColor, objectColor, objectShape } from './draw/labels.js';
export { EDGE_STYLES, drawSuperpixels } from './draw/superpixels.js';
export { drawTrajectories } from './draw/trajectories.js';

export type { Backdrop, CutoutMask, DrawCutoutOptions } from './draw/cutout.js';
export type {
  DrawBoundariesOptions,
  DrawDiscontinuitiesOptions,
  EdgeSource,
  FrameEdges,
  MapGrid,
} from './draw/maps.js';
export type { Shape } from './draw/labels.js';
export type { DrawSuperpixelsOptions, SuperpixelPicture } from './draw/superpixels.js';
export type { DrawTrajectoriesOptions, TrajectorySource } from './draw/trajectories.js';
