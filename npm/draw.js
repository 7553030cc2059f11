// What is drawn over frames: trajectories, superpixels, maps, cut-out objects. `drawLabels` is in the root entry.

export { fitFrame } from './draw/canvas.js';
export { drawCutout } from './draw/cutout.js';
export { drawDiscontinuities } from './draw/maps.js';
export { drawBoundaries, drawCells, drawFlow, drawSaliency } from './draw/maps.js';
export { CUT_RED, SCREEN_GREEN, flowColor, heatColor, objectColor, objectShape } from './draw/palette.js';
export { EDGE_STYLES, drawSuperpixels } from './draw/superpixels.js';
export { drawTrajectories } from './draw/trajectories.js';

/** @typedef {import('./draw/maps.js').DrawDiscontinuitiesOptions} DrawDiscontinuitiesOptions */
/** @typedef {import('./draw/maps.js').EdgeSource} EdgeSource */
/** @typedef {import('./draw/maps.js').FrameEdges} FrameEdges */
/** @typedef {import('./draw/maps.js').MapGrid} MapGrid */
/** @typedef {import('./draw/maps.js').DrawBoundariesOptions} DrawBoundariesOptions */
/** @typedef {import('./draw/superpixels.js').DrawSuperpixelsOptions} DrawSuperpixelsOptions */
/** @typedef {import('./draw/superpixels.js').SuperpixelPicture} SuperpixelPicture */
/** @typedef {import('./draw/trajectories.js').DrawTrajectoriesOptions} DrawTrajectoriesOptions */
/** @typedef {import('./draw/trajectories.js').TrajectorySource} TrajectorySource */
/** @typedef {import('./draw/palette.js').Shape} Shape */
/** @typedef {import('./draw/cutout.js').CutoutMask} CutoutMask */
/** @typedef {import('./draw/cutout.js').DrawCutoutOptions} DrawCutoutOptions */
/** @typedef {import('./draw/cutout.js').Ground} Ground */
