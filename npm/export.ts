// Further exports of masks as files and data, and estimates of a video before it is made.

import { loadPart } from './platform.js';

export { labelMaps, labelsNpy } from './kit/export/data.js';
export { estimateVideoSize } from './kit/export/video-options.js';

// These are loaded on their first call.
export const cocoRle: typeof import('./kit/export/annotations.js').cocoRle = async (...args) =>
  (await loadPart(import('./kit/export/annotations.js'))).cocoRle(...args);
export const fromCocoRle: typeof import('./kit/export/annotations.js').fromCocoRle = async (...args) =>
  (await loadPart(import('./kit/export/annotations.js'))).fromCocoRle(...args);
export const objectTable: typeof import('./kit/export/table.js').objectTable = async (...args) =>
  (await loadPart(import('./kit/export/table.js'))).objectTable(...args);
export const objectTableCsv: typeof import('./kit/export/table.js').objectTableCsv = async (...args) =>
  (await loadPart(import('./kit/export/table.js'))).objectTableCsv(...args);
export const prompts: typeof import('./kit/export/annotations.js').prompts = async (...args) =>
  (await loadPart(import('./kit/export/annotations.js'))).prompts(...args);
export const soundInfo: typeof import('./kit/export/video-file.js').soundInfo = async (...args) =>
  (await loadPart(import('./kit/export/video-file.js'))).soundInfo(...args);
export const clipsZip: typeof import('./kit/export/masks.js').clipsZip = async (...args) =>
  (await loadPart(import('./kit/export/masks.js'))).clipsZip(...args);
export const encodeImages: typeof import('./kit/export/images.js').encodeImages = async (...args) =>
  (await loadPart(import('./kit/export/images.js'))).encodeImages(...args);

export type {
  CocoAnnotation,
  CocoImage,
  CocoMasks,
  CocoOptions,
  CocoRle,
  ObjectPrompt,
  PromptList,
  PromptsOptions,
} from './kit/export/annotations.js';
export type { LabelMaps } from './kit/export/data.js';
export type { EncodeImagesOptions } from './kit/export/images.js';
export type { ClipsZipOptions, ZippedClip } from './kit/export/masks.js';
export type { ObjectRow, ObjectTableOptions, TrajectoryPoints } from './kit/export/table.js';
export type { SoundInfo } from './kit/export/video-file.js';
export type { VideoEstimate } from './kit/export/video-options.js';
