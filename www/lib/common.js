// What is the same in browsers and Node.

import { PARAMETERS, VERSION } from './parameters.js';
import { part } from './places.js';

export { Clip } from './clip.js';
export { fitFrame } from './draw/canvas.js';
export { cutOut, drawCutout } from './draw/cutout.js';
export { drawDiscontinuities } from './draw/discontinuities.js';
export { drawLabels } from './draw/labels.js';
export { drawBoundaries, drawCells, drawFlow, drawSaliency } from './draw/maps.js';
export { CUT_RED, flowColor, heatColor, objectColor, objectShape } from './draw/palette.js';
export { EDGE_STYLES, drawSuperpixels } from './draw/superpixels.js';
export { trailFrames } from './draw/trail.js';
export { drawTrajectories } from './draw/trajectories.js';
export { divideRegions, pieceRegion } from './edit/divide.js';
export { MaskEditor, editMasks } from './edit/editor.js';
export { regionOf, strokeRegion } from './edit/regions.js';
export { TraceCutError } from './errors.js';
export { adjustMask } from './export/adjust.js';
export { cocoRle } from './export/coco.js';
export { labelMaps, labelsNpy } from './export/label-maps.js';
export { fromCocoRle } from './export/rle.js';
export { estimateVideoSize } from './export/quality.js';
export { soundInfo } from './export/sound.js';
export { EdgeKind, ImageEngine } from './image.js';
export { searchReport } from './report.js';
export { configure } from './places.js';
export { Result } from './result.js';
export { sceneMotion } from './scene.js';
export { Session } from './session.js';
export { tracksDat } from './tracks-dat.js';
export { VideoResult } from './video/result.js';
export { VideoSegmentation } from './video/segment.js';
export { WindowResult } from './video/window.js';

/** The package's version. */
export const version = VERSION;

/**
 * All parameters with their meaning, kind, range and default, in the order of the stages.
 * @returns {import('./parameters.js').Parameter[]}
 */
export function parameters() {
  return PARAMETERS.map((parameter) => ({ ...parameter }));
}

/**
 * Opens what `saveProject` made.
 * @param {Uint8Array | ArrayBuffer | Blob} file
 * @returns {Promise<import('./export/project.js').Project>}
 */
export async function openProject(file) {
  const { projectFrom } = await part(import('./export/project.js'));
  return projectFrom(file);
}

/**
 * Where each object is in each frame, how large and how it moves: a row for each frame and object in it, by frame, then
 * by label. `JSON.stringify` and `objectTableCsv` write them.
 *
 * ```js
 * for (const { frame, object, x, y } of await objectTable(result)) console.log(frame, object, x, y);
 * ```
 * @param {import('./export/mask-source.js').MaskSource & {trajectories?: import('./export/table.js').TrajectoryPoints}} masks
 * @param {import('./export/table.js').ObjectTableOptions} [options]
 * @returns {Promise<import('./export/table.js').ObjectRow[]>}
 */
export async function objectTable(masks, options) {
  const { tableOf } = await part(import('./export/table.js'));
  return tableOf(masks, options);
}

/**
 * Rows of `objectTable` as a table of comma-separated values, with a heading; the command line writes the same as
 * `objects.csv`. Places have three decimals, what is null is left empty.
 * @param {readonly import('./export/table.js').ObjectRow[]} rows
 * @returns {Promise<string>}
 */
export async function objectTableCsv(rows) {
  const { csvOf } = await part(import('./export/table.js'));
  return csvOf(rows);
}

/**
 * Reads a track file. How large the frames are is not in it.
 *
 * ```js
 * await session.setTrajectories(await fromTracksDat(text, { width: 640, height: 480 }));
 * ```
 * @param {string} text
 * @param {{readonly width: number, readonly height: number}} size of the frames in pixels
 * @returns {Promise<import('./tracks-file.js').TrackFile>}
 */
export async function fromTracksDat(text, size) {
  const { readTracks } = await part(import('./tracks-file.js'));
  return readTracks(text, size);
}

/** @typedef {import('./errors.js').ErrorCode} ErrorCode */
/** @typedef {import('./options.js').SessionOptions} SessionOptions */
/** @typedef {import('./parameters.js').Parameter} Parameter */
/** @typedef {import('./frames.js').FrameSource} FrameSource */
/** @typedef {import('./clip.js').ClipOptions} ClipOptions */
/** @typedef {import('./trajectories.js').TrajectoryInput} TrajectoryInput */
/** @typedef {import('./correction.js').Place} Place */
/** @typedef {import('./engine.js').Progress} Progress */
/** @typedef {import('./engine.js').Stage} Stage */
/** @typedef {import('./engine.js').FlowField} FlowField */
/** @typedef {import('./enlarge-here.js').EnlargedMask} EnlargedMask */
/** @typedef {import('./enlarge.js').EnlargeOptions} EnlargeOptions */
/** @typedef {import('./enlarge.js').FrameMask} FrameMask */
/** @typedef {import('./image.js').BoundaryMap} BoundaryMap */
/** @typedef {import('./image.js').DiscontinuityOptions} DiscontinuityOptions */
/** @typedef {import('./image.js').FlowOptions} FlowOptions */
/** @typedef {import('./image.js').ImageEngineOptions} ImageEngineOptions */
/** @typedef {import('./image.js').ImageDiscontinuities} ImageDiscontinuities */
/** @typedef {import('./image.js').ImageOptions} ImageOptions */
/** @typedef {import('./image.js').SuperpixelOptions} SuperpixelOptions */
/** @typedef {import('./image.js').Superpixels} Superpixels */
/** @typedef {import('./result.js').Background} Background */
/** @typedef {import('./result.js').ComponentTable} ComponentTable */
/** @typedef {import('./result.js').ClusterObjects} ClusterObjects */
/** @typedef {import('./result.js').ConfidenceMap} ConfidenceMap */
/** @typedef {import('./result.js').Explanation} Explanation */
/** @typedef {import('./result.js').LabelCost} LabelCost */
/** @typedef {import('./result.js').SuperpixelLink} SuperpixelLink */
/** @typedef {import('./result.js').Voter} Voter */
/** @typedef {import('./objects.js').ObjectList} ObjectList */
/** @typedef {import('./result.js').SaliencyMap} SaliencyMap */
/** @typedef {import('./result.js').SaliencyTable} SaliencyTable */
/** @typedef {import('./report.js').Searched} Searched */
/** @typedef {import('./report.js').SearchReport} SearchReport */
/** @typedef {import('./scene.js').LabelledTrajectories} LabelledTrajectories */
/** @typedef {import('./scene.js').SceneMotion} SceneMotion */
/** @typedef {import('./session.js').RunOptions} RunOptions */
/** @typedef {import('./video/frames.js').DecodedFrame} DecodedFrame */
/** @typedef {import('./video/listed.js').FrameAtTime} FrameAtTime */
/** @typedef {import('./video/listed.js').ListedFrame} ListedFrame */
/** @typedef {import('./video/options.js').Damage} Damage */
/** @typedef {import('./video/options.js').TakeOptions} TakeOptions */
/** @typedef {import('./video/reader.js').VideoInfo} VideoInfo */
/** @typedef {import('./video/result.js').Shot} Shot */
/** @typedef {import('./objects.js').VideoObject} VideoObject */
/** @typedef {import('./video/segment.js').VideoOptions} VideoOptions */
/** @typedef {import('./video/segment.js').VideoProgress} VideoProgress */
/** @typedef {import('./video/source.js').VideoSource} VideoSource */
/** @typedef {import('./video/strip.js').StripOptions} StripOptions */
/** @typedef {import('./video/tracks.js').ClipTrajectories} ClipTrajectories */
/** @typedef {import('./video/window.js').SettledFrame} SettledFrame */
/** @typedef {import('./draw/canvas.js').Context2D} Context2D */
/** @typedef {import('./draw/cutout.js').CutoutMask} CutoutMask */
/** @typedef {import('./draw/cutout.js').Cutout} Cutout */
/** @typedef {import('./draw/cutout.js').DrawCutoutOptions} DrawCutoutOptions */
/** @typedef {import('./draw/trail.js').TrailOptions} TrailOptions */
/** @typedef {import('./draw/trail.js').TrailFrame} TrailFrame */
/** @typedef {import('./draw/cutout.js').Ground} Ground */
/** @typedef {import('./draw/discontinuities.js').DrawDiscontinuitiesOptions} DrawDiscontinuitiesOptions */
/** @typedef {import('./draw/discontinuities.js').EdgeSource} EdgeSource */
/** @typedef {import('./draw/labels.js').DrawLabelsOptions} DrawLabelsOptions */
/** @typedef {import('./draw/maps.js').DrawBoundariesOptions} DrawBoundariesOptions */
/** @typedef {import('./draw/superpixels.js').DrawSuperpixelsOptions} DrawSuperpixelsOptions */
/** @typedef {import('./draw/trajectories.js').DrawTrajectoriesOptions} DrawTrajectoriesOptions */
/** @typedef {import('./draw/trajectories.js').TrajectorySource} TrajectorySource */
/** @typedef {import('./draw/palette.js').LabelColors} LabelColors */
/** @typedef {import('./draw/palette.js').Shape} Shape */
/** @typedef {import('./export/adjust.js').AdjustMaskOptions} AdjustMaskOptions */
/** @typedef {import('./export/adjust.js').MaskEdges} MaskEdges */
/** @typedef {import('./edit/carry.js').CarryOptions} CarryOptions */
/** @typedef {import('./edit/editor.js').Edit} Edit */
/** @typedef {import('./edit/editor.js').SavedEdits} SavedEdits */
/** @typedef {import('./edit/smooth.js').SmoothMasksOptions} SmoothMasksOptions */
/** @typedef {import('./edit/regions.js').BrushStroke} BrushStroke */
/** @typedef {import('./edit/regions.js').Region} Region */
/** @typedef {import('./export/at-size.js').MasksAtSizeOptions} MasksAtSizeOptions */
/** @typedef {import('./export/clips-zip.js').ClipsZipOptions} ClipsZipOptions */
/** @typedef {import('./export/clips-zip.js').ZippedClip} ZippedClip */
/** @typedef {import('./video/each.js').EachOptions} EachOptions */
/** @typedef {import('./video/each.js').QueuedClip} QueuedClip */
/** @typedef {import('./video/each.js').SegmentedClip} SegmentedClip */
/** @typedef {import('./export/coco.js').CocoAnnotation} CocoAnnotation */
/** @typedef {import('./export/coco.js').CocoImage} CocoImage */
/** @typedef {import('./export/coco.js').CocoMasks} CocoMasks */
/** @typedef {import('./export/coco.js').CocoOptions} CocoOptions */
/** @typedef {import('./export/label-maps.js').LabelMaps} LabelMaps */
/** @typedef {import('./export/mask-source.js').MaskSource} MaskSource */
/** @typedef {import('./export/mask-source.js').ObjectChoice} ObjectChoice */
/** @typedef {import('./export/masks.js').ExportProgress} ExportProgress */
/** @typedef {import('./export/masks.js').MaskPngOptions} MaskPngOptions */
/** @typedef {import('./export/masks.js').MasksZipOptions} MasksZipOptions */
/** @typedef {import('./export/project.js').Project} Project */
/** @typedef {import('./export/project.js').ProjectOptions} ProjectOptions */
/** @typedef {import('./export/rle.js').CocoRle} CocoRle */
/** @typedef {import('./export/table.js').ObjectRow} ObjectRow */
/** @typedef {import('./export/table.js').ObjectTableOptions} ObjectTableOptions */
/** @typedef {import('./export/table.js').TrajectoryPoints} TrajectoryPoints */
/** @typedef {import('./tracking.js').TrackedClip} TrackedClip */
/** @typedef {import('./tracking.js').TrajectoryOptions} TrajectoryOptions */
/** @typedef {import('./tracking.js').TrackingProgress} TrackingProgress */
/** @typedef {import('./tracks-file.js').TrackFile} TrackFile */
/** @typedef {import('./tracks-dat.js').TracksToWrite} TracksToWrite */
/** @typedef {import('./export/images.js').EncodeImagesOptions} EncodeImagesOptions */
/** @typedef {import('./export/video.js').EncodeFrame} EncodeFrame */
/** @typedef {import('./export/video.js').EncodeFrames} EncodeFrames */
/** @typedef {import('./export/video.js').EncodeVideoOptions} EncodeVideoOptions */
/** @typedef {import('./export/quality.js').VideoEstimate} VideoEstimate */
/** @typedef {import('./export/quality.js').VideoQuality} VideoQuality */
/** @typedef {import('./export/sound.js').SoundInfo} SoundInfo */
/** @typedef {import('./export/sound.js').SoundOptions} SoundOptions */
/** @typedef {import('./correction.js').Stroke} Stroke */
