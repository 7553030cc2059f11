// Masks as plain arrays.

import { checkOptions } from '../../check/errors.js';
import { type MaskSource, checkMasks, getTimes, readLabels } from '../../check/masks.js';

/**
 * All masks in one array: the label of pixel (x, y) of frame `t` is `data[(t * height + y) * width + x]`. `times` are
 * the frames' times in seconds, null if unknown.
 */
export type LabelMaps = {
  readonly width: number;
  readonly height: number;
  readonly numFrames: number;
  readonly data: Uint8Array<ArrayBuffer>;
  readonly times: Float64Array<ArrayBuffer> | null;
};

/**
 * Copies all masks to one array.
 * @param options `frameRate`, in frames per second, sets the times of masks that have none
 */
export function labelMaps(masks: MaskSource, options: { frameRate?: number } = {}): LabelMaps {
  checkMasks(masks);
  const { frameRate } = checkOptions(options, ['frameRate']);
  const times = getTimes(masks, frameRate);
  const { width, height, numFrames } = masks;
  const data = new Uint8Array(numFrames * height * width);
  for (let t = 0; t < numFrames; t += 1) data.set(readLabels(masks, t), t * height * width);
  return { width, height, numFrames, data, times };
}

/** Alignment of the header's end in NumPy's format, in bytes. */
const HEADER_ALIGNMENT = 64;

/**
 * Encodes all masks for NumPy: `numpy.load` returns an array of bytes, frames × height × width.
 * @returns the bytes of a `.npy` file
 */
export function labelsNpy(masks: MaskSource): Uint8Array<ArrayBuffer> {
  const { width, height, numFrames, data } = labelMaps(masks);
  const header = `{'descr': '|u1', 'fortran_order': False, 'shape': (${numFrames}, ${height}, ${width}), }`;
  const length = Math.ceil((10 + header.length + 1) / HEADER_ALIGNMENT) * HEADER_ALIGNMENT;
  const text = `\x93NUMPY\x01\x00${String.fromCharCode((length - 10) & 255, (length - 10) >> 8)}${header}`.padEnd(
    length - 1,
    ' ',
  );
  const file = new Uint8Array(length + data.length);
  for (let k = 0; k < length; k += 1) file[k] = k < length - 1 ? text.charCodeAt(k) : 10;
  file.set(data, length);
  return file;
}

/** Returns the name of frame `t`'s file in an archive of masks. */
export function formatPngName(t: number) {
  return `${String(t).padStart(5, '0')}.png`;
}
