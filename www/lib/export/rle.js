/**
 * Run lengths of masks as COCO has them: columns from left to right, each from top to bottom; first a run of 0, which
 * may be empty, then of 1, and so on. As a string, each length is a signed number in groups of five bits, from the
 * third on as its difference from the last but one, so that pycocotools reads it.
 */

import { TraceCutError, illegal, isPlainObject, wholeNumber } from '../errors.js';

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
export function toCounts(counts) {
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
