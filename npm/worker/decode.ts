// Calls the decoder's wasm module in this thread: PNG and JPEG files to pixels, masks to the size of their pictures and to
// data.

import { type ErrorCode, TraceCutError, throwIfRust } from '../check/errors.js';
import startDecoder, { __wbg_reset_state, decode, enlarge } from '../decoder.js';
import { type RawFrame, fromImage } from './frames.js';

let starting: Promise<unknown> | undefined;

export type Pixels = { data: Uint8Array<ArrayBuffer>; width: number; height: number };

/** Decodes the pixels of a frame. */
export async function toPixels(frame: RawFrame): Promise<Pixels> {
  if (frame.kind === 'pixels') return frame;
  if (!frame.decoder) throw new TraceCutError('state', 'a file came without the module that decodes it');
  const call = () => decode(frame.data, frame.maxPixels);
  const [data, width, height] = await callDecoder(frame.decoder, call, 'image cannot be decoded', 'decode');
  return { data, width, height };
}

/**
 * Calls into the module after it has started. An error that Rust returned has a code; anything else is a panic or a trap.
 * @param failure description of a failed call
 * @param code of its error
 */
export async function callDecoder<T>(
  module: WebAssembly.Module,
  call: () => T,
  failure: string,
  code: ErrorCode = 'poisoned',
): Promise<T> {
  starting ??= startDecoder({ module_or_path: module });
  await starting;
  try {
    return call();
  } catch (error) {
    throwIfRust(error);
    // The next call gets a fresh instance.
    __wbg_reset_state();
    throw new TraceCutError(code, `${failure}: the decoder stopped on an internal error: ${error}`, { cause: error });
  }
}

/**
 * A mask at the size of its picture: `labels` holds the label of each pixel, `alpha` the opacity of the selected objects
 * there, 0 to 255: at least 128 exactly where the label is selected, soft where the picture has a soft edge, and 0 or 255
 * away from their borders.
 */
export type EnlargedMask = {
  readonly width: number;
  readonly height: number;
  readonly labels: Uint8Array<ArrayBuffer>;
  readonly alpha: Uint8Array<ArrayBuffer>;
};

/** A picture that a worker reads, as reading it would be noticed in the page's thread. */
export type HeldImage = { kind: 'image'; image: VideoFrame | ImageBitmap };

/** A mask and its picture, in memory that nothing else uses. */
export type EnlargeTask = {
  labels: Uint8Array<ArrayBuffer>;
  width: number;
  picture: RawFrame | HeldImage;
  chosen: Uint8Array<ArrayBuffer>;
  /** True to return the picture's pixels too. */
  readsPicture?: boolean;
  module: WebAssembly.Module;
};

/** A mask, and the RGBA pixels of its picture if requested. */
export type EnlargedFrame = EnlargedMask & { picture?: Uint8Array<ArrayBuffer> };

/** Enlarges a mask in this thread. */
export async function enlargeInThread(task: EnlargeTask): Promise<EnlargedFrame> {
  const { labels, width, chosen, module } = task;
  const pixels = await readPixels(task.picture);
  const call = () => enlarge(labels, width, pixels.data, pixels.width, pixels.height, chosen);
  const [large, alpha] = await callDecoder(module, call, 'the mask cannot be enlarged');
  const picture = task.readsPicture ? { picture: pixels.data } : {};
  return { width: pixels.width, height: pixels.height, labels: large, alpha, ...picture };
}

async function readPixels(picture: EnlargeTask['picture']) {
  if (picture.kind !== 'image') return toPixels(picture);
  try {
    return await toPixels(await fromImage(picture.image));
  } finally {
    picture.image.close();
  }
}
