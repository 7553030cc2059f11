// Masks as PNG files, and a ZIP of them.

import { aside, pngOf } from '../aside/aside.js';
import { colorsOf, rgbOf } from '../draw/palette.js';
import { checkFlag, checkedOptions, illegal, wholeNumber } from '../errors.js';
import { VERSION } from '../parameters.js';
import { Encoder } from '../text.js';
import { breath } from './breath.js';
import { pngName } from './coco.js';
import { MAX_LABEL, checkMasks, chosenLabels, firstOf, labelsOf, timesOf } from './mask-source.js';

/** @typedef {import('./mask-source.js').MaskSource} MaskSource */

/**
 * How a mask is written. Without `object` the file's pixel values are the labels, shown in the colours of a palette.
 * @typedef {object} MaskPngOptions
 * @property {number} [object] the label of one object, 0 to 255, that is in the clip: the file is grey, 255 where that
 *   label
 *   is, else 0
 * @property {import('../draw/palette.js').LabelColors} [palette] the colours that labels are shown in; `objectColor`,
 *   and
 *   black for label 0, if not given
 * @property {boolean} [transparent] whether label 0, or with `object` all but that object, is shown as nothing; false
 *   if not
 *   given
 */

/**
 * What an archive of masks holds.
 * @typedef {object} MasksZipOptions
 * @property {boolean} [perObject] true for a folder for each object, `object-1/00000.png` and so on, of files that are
 *   255
 *   where it is and else 0; else a file for each frame whose pixel values are the labels
 * @property {import('./mask-source.js').ObjectChoice} [objects] others are left out (they become 0); all but the
 *   background
 *   if not given
 * @property {import('../draw/palette.js').LabelColors} [palette] the colours that labels are shown in, as of single
 *   files
 * @property {boolean} [transparent] whether what is no object is shown as nothing; false if not given
 * @property {number} [frameRate] frames per second, above 0, up to 1000: gives times to masks that have none
 * @property {(progress: ExportProgress) => void} [onProgress] told of each frame
 * @property {AbortSignal} [signal] ends the work: the promise rejects with its reason
 */

/** How far an export is, in frames. @typedef {{done: number, total: number}} ExportProgress */

/** The colour of label 0 in files: black, as readers of masks expect it. */
const BLACK = '#000000';

/** Frames that are written before others may do something. */
const BATCH = 4;

/**
 * The mask of frame `t` as a PNG file: in palette colours, or of one object in black and white.
 * @param {import('./mask-source.js').MaskSource} masks
 * @param {number} t
 * @param {MaskPngOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the bytes of the file
 */
export async function maskPng(masks, t, options = {}) {
  checkMasks(masks);
  const { object, palette, transparent = false } = checkedOptions(options, ['object', 'palette', 'transparent']);
  checkFlag('transparent', transparent);
  if (object !== undefined) wholeNumber('param', 'object', object, 0, MAX_LABEL);
  const labels = labelsOf(masks, t);
  const { width, height } = masks;
  if (object !== undefined) {
    await checkThere(masks, labels, object);
    return pngOf({ pixels: only(labels, object), width, height, ...clearGrey(transparent) });
  }
  return pngOf({ pixels: Uint8Array.from(labels), width, height, ...table(palette, transparent) });
}

/**
 * Refuses an object that no frame has; one that this frame alone does not have gives an empty mask.
 * @param {MaskSource} masks
 * @param {Uint8Array} labels of the frame at hand
 * @param {number} object
 */
async function checkThere(masks, labels, object) {
  if (object === 0 || labels.includes(object)) return;
  const present = await presentLabels(masks, chosenLabels(undefined));
  if (present.includes(object)) return;
  const legal = present.length > 0 ? `the label of an object: ${present.join(', ')}` : 'no object: there are none';
  throw illegal('param', 'object', object, legal);
}

/**
 * Grey files have no palette whose entries could be clear: one value is, here 0.
 * @param {boolean} transparent
 */
function clearGrey(transparent) {
  return transparent ? { alpha: Uint8Array.of(0, 0) } : {};
}

/**
 * @param {Uint8Array} labels
 * @param {number} object
 */
function only(labels, object) {
  return Uint8Array.from(labels, (label) => (label === object ? 255 : 0));
}

/**
 * @param {import('../draw/palette.js').LabelColors | undefined} palette
 * @param {boolean} transparent
 */
function table(palette, transparent) {
  const color = fileColors(palette);
  const rgb = new Uint8Array(3 * (MAX_LABEL + 1));
  for (let label = 0; label <= MAX_LABEL; label += 1) rgb.set(rgbOf(color(label)), 3 * label);
  return transparent ? { palette: rgb, alpha: Uint8Array.of(0) } : { palette: rgb };
}

/**
 * @param {import('../draw/palette.js').LabelColors | undefined} palette
 * @returns {(label: number) => string}
 */
function fileColors(palette) {
  const color = colorsOf(palette);
  return (label) => (label === 0 && palette === undefined ? BLACK : color(label));
}

/**
 * All masks in one ZIP archive: PNG files, and `masks.json`, which says the frames' times and files, the labels and
 * their colours. The same masks give the same bytes.
 * @param {import('./mask-source.js').MaskSource} masks
 * @param {MasksZipOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the bytes of the archive
 */
export async function masksZip(masks, options = {}) {
  const files = await filesOfMasks(masks, options);
  // PNG files are compressed already.
  const bytes = Object.values(files).map(({ buffer }) => buffer);
  return aside({ kind: 'zip', files, stored: Object.keys(files) }, bytes);
}

/**
 * What the archive holds, by name.
 * @param {MaskSource} masks
 * @param {MasksZipOptions} options
 * @returns {Promise<Record<string, Uint8Array<ArrayBuffer>>>}
 */
export async function filesOfMasks(masks, options) {
  checkMasks(masks);
  const legal = ['perObject', 'objects', 'palette', 'transparent', 'frameRate', 'onProgress', 'signal'];
  const {
    perObject = false,
    objects,
    palette,
    transparent = false,
    frameRate,
    onProgress,
    signal,
  } = checkedOptions(options, legal);
  checkFlag('perObject', perObject);
  checkFlag('transparent', transparent);
  const times = timesOf(masks, frameRate);
  const chosen = chosenLabels(objects);
  const colors = table(palette, transparent);
  const { width, height, numFrames } = masks;
  const size = { width, height, ...clearGrey(transparent) };
  const first = firstOf(masks);
  const present = await presentLabels(masks, chosen);
  /** @type {Record<string, Uint8Array<ArrayBuffer>>} */
  const files = {};
  for (let t = 0; t < numFrames; t += 1) {
    signal?.throwIfAborted();
    const labels = labelsOf(masks, t);
    if (perObject)
      for (const label of present)
        files[objectFile(label, first + t)] = await pngOf({ pixels: only(labels, label), ...size });
    else {
      const pixels = new Uint8Array(labels.length);
      for (let p = 0; p < pixels.length; p += 1) if (chosen[Number(labels[p])]) pixels[p] = Number(labels[p]);
      files[pngName(first + t)] = await pngOf({ pixels, width, height, ...colors });
    }
    onProgress?.({ done: t + 1, total: numFrames });
    if (t % BATCH === BATCH - 1) await breath();
  }
  const about = description(masks, times, present, { palette, perObject });
  files['masks.json'] = new Encoder().encode(`${JSON.stringify(about, null, 2)}\n`);
  return files;
}

/**
 * What `masks.json` says.
 * @param {MaskSource} masks
 * @param {Float64Array | null} times
 * @param {number[]} labels
 * @param {{palette: import('../draw/palette.js').LabelColors | undefined, perObject: boolean}} options
 */
function description(masks, times, labels, { palette, perObject }) {
  const { width, height, numFrames, shots, end } = masks;
  const color = fileColors(palette);
  const first = firstOf(masks);
  const named = (/** @type {(t: number) => string} */ name) =>
    Array.from({ length: numFrames }, (_, t) => name(first + t));
  return {
    generator: 'tracecut',
    version: VERSION,
    width,
    height,
    numFrames,
    ...(first > 0 ? { firstFrame: first } : {}),
    times: times && [...times],
    ...(times && typeof end === 'number' ? { end } : {}),
    ...(Array.isArray(shots) ? { shots: shots.map(({ first, last }) => ({ first, last })) } : {}),
    labels,
    palette: Object.fromEntries([0, ...labels].map((label) => [label, color(label)])),
    files: perObject
      ? Object.fromEntries(labels.map((label) => [label, named((t) => objectFile(label, t))]))
      : named(pngName),
  };
}

/**
 * @param {number} label
 * @param {number} t
 */
function objectFile(label, t) {
  return `object-${label}/${pngName(t)}`;
}

/**
 * @param {MaskSource} masks
 * @param {Uint8Array} chosen
 * @returns {Promise<number[]>} the chosen labels that are in any frame, 0 left out
 */
async function presentLabels(masks, chosen) {
  const seen = new Uint8Array(MAX_LABEL + 1);
  for (let t = 0; t < masks.numFrames; t += 1) {
    const labels = labelsOf(masks, t);
    for (let p = 0; p < labels.length; p += 1) seen[Number(labels[p])] = 1;
    if (t % BATCH === BATCH - 1) await breath();
  }
  return [...seen.keys()].filter((label) => label > 0 && seen[label] && chosen[label]);
}
