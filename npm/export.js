// Masks as files besides those of the root entry, as data, and what is known of a video before it is made.

import { part } from './places.js';

export { labelMaps, labelsNpy } from './kit/export/data.js';
export { estimateVideoSize } from './kit/export/quality.js';
export { soundInfo } from './kit/export/sound.js';

// These are loaded when they are first called.
/** @type {typeof import('./kit/export/coco.js').cocoRle} */
export const cocoRle = async (...args) => (await part(import('./kit/export/coco.js'))).cocoRle(...args);
/** @type {typeof import('./kit/export/coco.js').fromCocoRle} */
export const fromCocoRle = async (...args) => (await part(import('./kit/export/coco.js'))).fromCocoRle(...args);
/** @type {typeof import('./kit/export/table.js').objectTable} */
export const objectTable = async (...args) => (await part(import('./kit/export/table.js'))).objectTable(...args);
/** @type {typeof import('./kit/export/table.js').objectTableCsv} */
export const objectTableCsv = async (...args) => (await part(import('./kit/export/table.js'))).objectTableCsv(...args);
/** @type {typeof import('./kit/export/prompts.js').prompts} */
export const prompts = async (...args) => (await part(import('./kit/export/prompts.js'))).prompts(...args);
/** @type {typeof import('./kit/export/masks.js').clipsZip} */
export const clipsZip = async (...args) => (await part(import('./kit/export/masks.js'))).clipsZip(...args);
/** @type {typeof import('./kit/export/images.js').encodeImages} */
export const encodeImages = async (...args) => (await part(import('./kit/export/images.js'))).encodeImages(...args);

/** @typedef {import('./kit/export/masks.js').ClipsZipOptions} ClipsZipOptions */
/** @typedef {import('./kit/export/masks.js').ZippedClip} ZippedClip */
/** @typedef {import('./kit/export/coco.js').CocoAnnotation} CocoAnnotation */
/** @typedef {import('./kit/export/coco.js').CocoImage} CocoImage */
/** @typedef {import('./kit/export/coco.js').CocoMasks} CocoMasks */
/** @typedef {import('./kit/export/coco.js').CocoOptions} CocoOptions */
/** @typedef {import('./kit/export/data.js').LabelMaps} LabelMaps */
/** @typedef {import('./kit/export/coco.js').CocoRle} CocoRle */
/** @typedef {import('./kit/export/table.js').ObjectRow} ObjectRow */
/** @typedef {import('./kit/export/table.js').ObjectTableOptions} ObjectTableOptions */
/** @typedef {import('./kit/export/table.js').TrajectoryPoints} TrajectoryPoints */
/** @typedef {import('./kit/export/images.js').EncodeImagesOptions} EncodeImagesOptions */
/** @typedef {import('./kit/export/prompts.js').ObjectPrompt} ObjectPrompt */
/** @typedef {import('./kit/export/prompts.js').PromptList} PromptList */
/** @typedef {import('./kit/export/prompts.js').PromptsOptions} PromptsOptions */
/** @typedef {import('./kit/export/quality.js').VideoEstimate} VideoEstimate */
/** @typedef {import('./kit/export/sound.js').SoundInfo} SoundInfo */
