// Masks as plain arrays.

import { checkedOptions } from '../../check/errors.js';
import { type MaskSource, checkMasks, labelsOf, timesOf } from '../../check/masks.js';

/**
 * All masks in one array: the label of pixel (x, y) of frame `t` is `data[(t * height + y) * width + x]`. `times` are
 * the frames' times in seconds, null where none are known.
 */
export type LabelMaps = {
  readonly width: number;
  readonly height: number;
  readonly numFrames: number;
  readonly data: Uint8Array<ArrayBuffer>;
  readonly times: Float64Array<ArrayBuffer> | null;
};

/**
 * All masks in one array.
 * @param options `frameRate`, in frames per second, gives times to masks that have none
 */
export function labelMaps(masks: MaskSource, options: { frameRate?: number } = {}): LabelMaps {
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
 * @returns the bytes of a `.npy` file
 */
export function labelsNpy(masks: MaskSource): Uint8Array<ArrayBuffer> {
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

/** The name of frame `t`'s file in an archive of masks. */
export function pngName(t: number) {
  return `${String(t).padStart(5, '0')}.png`;
}
