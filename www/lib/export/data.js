// Masks as data: plain arrays, and run lengths and the JSON for videos of COCO.

import { TraceCutError, checkedOptions, illegal, isPlainObject, wholeNumber } from '../check/errors.js';
import { MAX_LABEL, checkMasks, chosenLabels, firstOf, labelsOf, timesOf } from '../check/masks.js';
import { VERSION } from '../parameters.js';

/**
 * All masks in one array: the label of pixel (x, y) of frame `t` is `data[(t * height + y) * width + x]`. `times` are
 * the frames' times in seconds, null where none are known.
 * @typedef {{readonly width: number, readonly height: number, readonly numFrames: number, readonly data:
 *   Uint8Array<ArrayBuffer>, readonly times:
 *   Float64Array<ArrayBuffer> | null}} LabelMaps
 */

/**
 * All masks in one array.
 * @param {import('../check/masks.js').MaskSource} masks
 * @param {{frameRate?: number}} [options] `frameRate`, in frames per second, gives times to masks that have none
 * @returns {LabelMaps}
 */
export function labelMaps(masks, options = {}) {
  checkMasks(masks);
  const { frameRate } = checkedOptions(options, ['frameRate']);
  const times = timesOf(masks, frameRate);
  const { width, height, numFrames } = masks;
  const data = new Uint8Array(numFrames * height * width);
  for (let t = 0; t < numFrames; t += 1) data.set(labelsOf(masks, t), t * height * width);
  return { width, height, numFrames, data, times };
}

/** What NumPy's format wants the header's end to be a multiple of. */
const ALIGNMENT = 64;

/**
 * All masks as a file for NumPy: `numpy.load` gives an array of bytes, frames × height × width.
 * @param {import('../check/masks.js').MaskSource} masks
 * @returns {Uint8Array<ArrayBuffer>} the bytes of a `.npy` file
 */
export function labelsNpy(masks) {
  const { width, height, numFrames, data } = labelMaps(masks);
  const about = `{'descr': '|u1', 'fortran_order': False, 'shape': (${numFrames}, ${height}, ${width}), }`;
  const length = Math.ceil((10 + about.length + 1) / ALIGNMENT) * ALIGNMENT;
  const text = `\x93NUMPY\x01\x00${String.fromCharCode((length - 10) & 255, (length - 10) >> 8)}${about}`.padEnd(
    length - 1,
    ' ',
  );
  const file = new Uint8Array(length + data.length);
  for (let k = 0; k < length; k += 1) file[k] = k < length - 1 ? text.charCodeAt(k) : 10;
  file.set(data, length);
  return file;
}

// Run lengths of masks as COCO has them: columns from left to right, each from top to bottom; first a run of 0, which
// may be empty, then of 1, and so on. As a string, each length is a signed number in groups of five bits, from the
// third on as its difference from the last but one, so that pycocotools reads it.

/**
 * A mask as COCO has it: `size` is height and width, `counts` its runs as a string, or as plain lengths.
 * @typedef {{size: readonly number[], counts: string | readonly number[]}} CocoRle
 */

/**
 * The mask of one label in one frame; `bbox` is left, top, width, height.
 * @typedef {{label: number, counts: number[], area: number, bbox: [number, number, number, number]}} LabelRuns
 */

const MAX_SIDE = 65535;
const FIRST_CHARACTER = 48;

/**
 * The runs of every label of a frame, in one pass over it.
 * @param {Uint8Array} labels row by row
 * @param {number} width
 * @param {number} height
 * @returns {LabelRuns[]} of the labels that are there, ascending
 */
export function runsOf(labels, width, height) {
  /** @type {(LabelRuns & {end: number})[]} `end` is where the last run of 1 ends. */
  const found = [];
  let last = -1;
  let start = 0;
  const close = (/** @type {number} */ label, /** @type {number} */ end) => {
    const own = (found[label] ??= { label, counts: [], area: 0, bbox: [width, height, 0, 0], end: 0 });
    own.counts.push(start - own.end, end - start);
    own.area += end - start;
    own.end = end;
    stretch(own.bbox, start, end, height);
  };
  for (let x = 0, k = 0; x < width; x += 1) {
    for (let p = x; p < labels.length; p += width, k += 1) {
      const label = /** @type {number} */ (labels[p]);
      if (label === last) continue;
      if (last >= 0) close(last, k);
      last = label;
      start = k;
    }
  }
  close(last, labels.length);
  return found.filter(Boolean).map(({ end, bbox: [left, top, right, bottom], ...runs }) => {
    if (end < labels.length) runs.counts.push(labels.length - end);
    return { ...runs, bbox: [left, top, right - left, bottom - top] };
  });
}

/**
 * Makes a box hold a run.
 * @param {[number, number, number, number]} box left, top, right, bottom
 * @param {number} start
 * @param {number} end
 * @param {number} height
 */
function stretch(box, start, end, height) {
  const [left, right] = [Math.floor(start / height), Math.floor((end - 1) / height)];
  // A run that goes on in the next column touches both edges.
  const [top, bottom] = left === right ? [start % height, ((end - 1) % height) + 1] : [0, height];
  box[0] = Math.min(box[0], left);
  box[1] = Math.min(box[1], top);
  box[2] = Math.max(box[2], right + 1);
  box[3] = Math.max(box[3], bottom);
}

/**
 * @param {readonly number[]} counts
 * @returns {string}
 */
function toCounts(counts) {
  const codes = [];
  for (let i = 0; i < counts.length; i += 1) {
    let rest = Number(counts[i]) - (i > 2 ? Number(counts[i - 2]) : 0);
    for (let more = true; more;) {
      const five = rest & 31;
      rest >>= 5;
      // Bit 16 is the sign: what is left is over when it is nothing but that.
      more = rest !== (five & 16 ? -1 : 0);
      codes.push(String.fromCharCode(FIRST_CHARACTER + (more ? five | 32 : five)));
    }
  }
  return codes.join('');
}

/**
 * @param {string} text
 * @returns {number[]}
 */
function fromCounts(text) {
  /** @type {number[]} */
  const counts = [];
  for (let at = 0; at < text.length;) {
    let value = 0;
    for (let shift = 0, more = true; more; shift += 5) {
      const code = text.charCodeAt(at) - FIRST_CHARACTER;
      if (!(code >= 0 && code < 64) || shift > 30)
        throw illegal('data', 'counts', text, 'run lengths as COCO writes them');
      value |= (code & 31) << shift;
      more = (code & 32) !== 0;
      if (!more && code & 16 && shift < 27) value |= -1 << (shift + 5);
      at += 1;
    }
    counts.push(value + (counts.length > 2 ? Number(counts[counts.length - 2]) : 0));
  }
  return counts;
}

/**
 * The mask of a COCO segmentation, the inverse of what `cocoRle` writes.
 * @param {CocoRle} segmentation
 * @returns {Uint8Array<ArrayBuffer>} 0 or 1 for each pixel, row by row
 */
export function fromCocoRle(segmentation) {
  const { size, counts } = isPlainObject(segmentation) ? segmentation : { size: undefined, counts: undefined };
  if (!Array.isArray(size) || size.length !== 2 || !(typeof counts === 'string' || Array.isArray(counts))) {
    throw illegal('data', 'segmentation', segmentation, 'an object {size: [height, width], counts}');
  }
  const height = wholeNumber('data', 'size[0]', size[0], 1, MAX_SIDE);
  const width = wholeNumber('data', 'size[1]', size[1], 1, MAX_SIDE);
  const lengths = typeof counts === 'string' ? fromCounts(counts) : counts;
  const total = lengths.reduce(
    (sum, length, i) => sum + wholeNumber('data', `counts[${i}]`, length, 0, width * height),
    0,
  );
  if (total !== width * height)
    throw new TraceCutError('data', `counts cover ${total} pixels (expected ${width * height})`);
  const mask = new Uint8Array(width * height);
  let k = 0;
  lengths.forEach((length, i) => {
    for (const end = k + length; k < end; k += 1)
      if (i % 2 === 1) mask[(k % height) * width + Math.floor(k / height)] = 1;
  });
  return mask;
}

/**
 * @typedef {object} CocoOptions
 * @property {import('../check/masks.js').ObjectChoice} [objects] all but the background if not given
 * @property {(t: number) => string} [fileName] of each frame's image, by its number in the clip; `00000.png` and so on
 *   if not given
 * @property {string} [video] the clip's name; `video` if not given
 * @property {string | ((label: number) => string)} [category] of all objects, or of each; `object` if not given
 * @property {number} [frameRate] frames per second, where the masks have no times
 */

/**
 * A frame; `timestamp` is its time in seconds and missing where none is known. @typedef {{id: number, video_id: number,
 * frame_index: number, width: number, height: number, file_name: string, timestamp?: number}} CocoImage
 */

/**
 * An object in a frame. `track_id` is its label, the same in all frames, and under `attributes` for importers that
 * look there; `id` is the same whatever window the frame is written from; `bbox` is left, top, width and height in
 * pixels.
 * @typedef {{id: number, image_id: number, video_id: number, track_id: number, category_id: number, attributes:
 *   {track_id: number}, area: number, bbox: [number, number, number, number], iscrowd: 0, segmentation: {size:
 *   [number, number], counts: string}}}
 *   CocoAnnotation
 */

/**
 * A clip's masks as COCO has them: images are its frames, tracks its objects.
 * @typedef {{info: {description: string, version: string}, videos: {id: number, name: string, width: number, height:
 *   number}[], images: CocoImage[], tracks: {id: number, category_id: number, video_id: number}[], categories: {id:
 *   number, name: string}[], annotations: CocoAnnotation[]}} CocoMasks
 */

const LEGAL = ['objects', 'fileName', 'video', 'category', 'frameRate'];

/** There is one video; numbers start from 1, because pycocotools takes 0 for none. */
const VIDEO = 1;

/**
 * The masks as a COCO JSON for videos: an image for each frame, an annotation for each object in each frame where it
 * is, its pixels as compressed run lengths that pycocotools reads. Of a window of a clip the settled frames are
 * written,
 * with the clip's numbers: the images and annotations of all windows, one after the other, are those of the clip.
 * @param {import('../check/masks.js').MaskSource} masks
 * @param {CocoOptions} [options]
 * @returns {CocoMasks} for `JSON.stringify`
 */
export function cocoRle(masks, options = {}) {
  checkMasks(masks);
  const {
    objects,
    fileName = pngName,
    video = 'video',
    category = 'object',
    frameRate,
  } = checkedOptions(options, LEGAL);
  const chosen = chosenLabels(objects);
  const times = timesOf(masks, frameRate);
  const categories = new Categories(category);
  const { width, height } = masks;
  const { from, to } = framesOf(masks);
  const first = firstOf(masks);
  const images = Array.from({ length: to - from }, (_, k) => {
    const t = from + k;
    const index = first + t;
    const image = { id: index + 1, video_id: VIDEO, frame_index: index, width, height, file_name: fileName(index) };
    return times ? { ...image, timestamp: Number(times[t]) } : image;
  });
  /** @type {CocoAnnotation[]} */
  const annotations = [];
  /** @type {Set<number>} */
  const tracks = new Set();
  for (let t = from; t < to; t += 1) {
    for (const { label, counts, area, bbox } of runsOf(labelsOf(masks, t), width, height)) {
      if (!chosen[label]) continue;
      tracks.add(label);
      const ids = {
        // By frame and label, so that windows can be put together.
        id: (first + t) * (MAX_LABEL + 1) + label + 1,
        image_id: first + t + 1,
        video_id: VIDEO,
        track_id: label,
        category_id: categories.of(label),
        attributes: { track_id: label },
      };
      annotations.push({
        ...ids,
        area,
        bbox,
        iscrowd: 0,
        segmentation: { size: [height, width], counts: toCounts(counts) },
      });
    }
  }
  return {
    info: { description: 'Masks of moving objects by TraceCut', version: VERSION },
    videos: [{ id: VIDEO, name: video, width, height }],
    images,
    tracks: [...tracks]
      .sort((a, b) => a - b)
      .map((label) => ({ id: label, category_id: categories.of(label), video_id: VIDEO })),
    categories: categories.list,
    annotations,
  };
}

/**
 * The frames that are written: of a window those that it settles, so that over all windows each is there once.
 * @param {import('../check/masks.js').MaskSource & {settled?: {from: number, to: number}}} masks
 */
function framesOf({ numFrames, settled }) {
  return settled ?? { from: 0, to: numFrames };
}

/** Categories by name, numbered from 1 as they come up. */
class Categories {
  /** @param {string | ((label: number) => string)} category */
  constructor(category) {
    if (typeof category !== 'string' && typeof category !== 'function')
      throw illegal('param', 'category', category, 'a name, or a function of a label');
    this.name = typeof category === 'function' ? category : () => category;
    /** @type {{id: number, name: string}[]} */
    this.list = typeof category === 'string' ? [{ id: 1, name: category }] : [];
  }

  /** @param {number} label */
  of(label) {
    const name = this.name(label);
    const known = this.list.find((entry) => entry.name === name) ?? { id: this.list.length + 1, name };
    if (!this.list.includes(known)) this.list.push(known);
    return known.id;
  }
}

/**
 * The name of frame `t`'s file in an archive of masks.
 * @param {number} t
 */
export function pngName(t) {
  return `${String(t).padStart(5, '0')}.png`;
}
