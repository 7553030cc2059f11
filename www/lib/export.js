// Masks as files besides those of the root entry, as data, and what is known of a video before it is made.

import { part } from './places.js';

export { labelMaps, labelsNpy } from './export/data.js';
export { estimateVideoSize } from './export/quality.js';
export { soundInfo } from './export/sound.js';

// These are loaded when they are first called.
/** @type {typeof import('./export/coco.js').cocoRle} */
export const cocoRle = async (...args) => (await part(import('./export/coco.js'))).cocoRle(...args);
/** @type {typeof import('./export/coco.js').fromCocoRle} */
export const fromCocoRle = async (...args) => (await part(import('./export/coco.js'))).fromCocoRle(...args);
/** @type {typeof import('./export/table.js').objectTable} */
export const objectTable = async (...args) => (await part(import('./export/table.js'))).objectTable(...args);
/** @type {typeof import('./export/table.js').objectTableCsv} */
export const objectTableCsv = async (...args) => (await part(import('./export/table.js'))).objectTableCsv(...args);
/** @type {typeof import('./export/prompts.js').prompts} */
export const prompts = async (...args) => (await part(import('./export/prompts.js'))).prompts(...args);
/** @type {typeof import('./export/masks.js').clipsZip} */
export const clipsZip = async (...args) => (await part(import('./export/masks.js'))).clipsZip(...args);
/** @type {typeof import('./export/images.js').encodeImages} */
export const encodeImages = async (...args) => (await part(import('./export/images.js'))).encodeImages(...args);

/** @typedef {import('./export/masks.js').ClipsZipOptions} ClipsZipOptions */
/** @typedef {import('./export/masks.js').ZippedClip} ZippedClip */
/** @typedef {import('./export/coco.js').CocoAnnotation} CocoAnnotation */
/** @typedef {import('./export/coco.js').CocoImage} CocoImage */
/** @typedef {import('./export/coco.js').CocoMasks} CocoMasks */
/** @typedef {import('./export/coco.js').CocoOptions} CocoOptions */
/** @typedef {import('./export/data.js').LabelMaps} LabelMaps */
/** @typedef {import('./export/coco.js').CocoRle} CocoRle */
/** @typedef {import('./export/table.js').ObjectRow} ObjectRow */
/** @typedef {import('./export/table.js').ObjectTableOptions} ObjectTableOptions */
/** @typedef {import('./export/table.js').TrajectoryPoints} TrajectoryPoints */
/** @typedef {import('./export/images.js').EncodeImagesOptions} EncodeImagesOptions */
/** @typedef {import('./export/prompts.js').ObjectPrompt} ObjectPrompt */
/** @typedef {import('./export/prompts.js').PromptList} PromptList */
/** @typedef {import('./export/prompts.js').PromptsOptions} PromptsOptions */
/** @typedef {import('./export/quality.js').VideoEstimate} VideoEstimate */
/** @typedef {import('./export/sound.js').SoundInfo} SoundInfo */
