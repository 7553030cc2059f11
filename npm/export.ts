// Further exports of masks as files and data, and estimates of a video before it is made.

import { loadPart } from './places.js';

export { labelMaps, labelsNpy } from './kit/export/data.js';
export { estimateVideoSize } from './kit/export/quality.js';
export { soundInfo } from './kit/export/sound.js';

// These are loaded on their first call.
export const cocoRle: typeof import('./kit/export/coco.js').cocoRle = async (...args) =>
  (await loadPart(import('./kit/export/coco.js'))).cocoRle(...args);
export const fromCocoRle: typeof import('./kit/export/coco.js').fromCocoRle = async (...args) =>
  (await loadPart(import('./kit/export/coco.js'))).fromCocoRle(...args);
export const objectTable: typeof import('./kit/export/table.js').objectTable = async (...args) =>
  (await loadPart(import('./kit/export/table.js'))).objectTable(...args);
export const objectTableCsv: typeof import('./kit/export/table.js').objectTableCsv = async (...args) =>
  (await loadPart(import('./kit/export/table.js'))).objectTableCsv(...args);
export const prompts: typeof import('./kit/export/prompts.js').prompts = async (...args) =>
  (await loadPart(import('./kit/export/prompts.js'))).prompts(...args);
export const clipsZip: typeof import('./kit/export/masks.js').clipsZip = async (...args) =>
  (await loadPart(import('./kit/export/masks.js'))).clipsZip(...args);
export const encodeImages: typeof import('./kit/export/images.js').encodeImages = async (...args) =>
  (await loadPart(import('./kit/export/images.js'))).encodeImages(...args);

export type { CocoAnnotation, CocoImage, CocoMasks, CocoOptions, CocoRle } from './kit/export/coco.js';
export type { LabelMaps } from './kit/export/data.js';
export type { EncodeImagesOptions } from './kit/export/images.js';
export type { ClipsZipOptions, ZippedClip } from './kit/export/masks.js';
export type { ObjectPrompt, PromptList, PromptsOptions } from './kit/export/prompts.js';
export type { VideoEstimate } from './kit/export/quality.js';
export type { SoundInfo } from './kit/export/sound.js';
export type { ObjectRow, ObjectTableOptions, TrajectoryPoints } from './kit/export/table.js';
