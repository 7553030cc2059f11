// What the second wasm module does, in this thread: PNG and JPEG files to pixels, masks to the size of their pictures and to
// data.

import { type ErrorCode, TraceCutError, throwIfRust } from '../check/errors.js';
import startDecoder, { __wbg_reset_state, decode, enlarge } from '../decoder.js';
import { type RawFrame, fromImage } from './frames.js';

let started: Promise<unknown> | undefined;

export type Pixels = { data: Uint8Array<ArrayBuffer>; width: number; height: number };

/** The pixels of a frame on its way to the engine. */
export async function toPixels(frame: RawFrame): Promise<Pixels> {
  if (frame.kind === 'pixels') return frame;
  if (!frame.decoder) throw new TraceCutError('state', 'a file came without the module that decodes it');
  const call = () => decode(frame.data, frame.maxPixels);
  const [data, width, height] = await callDecoder(frame.decoder, call, 'image cannot be decoded', 'decode');
  return { data, width, height };
}

/**
 * Calls into the module, once it has started. An error that Rust returned has a code; anything else is a panic or a trap.
 * @param failure what cannot be done then
 * @param code of that
 */
export async function callDecoder<T>(
  module: WebAssembly.Module,
  call: () => T,
  failure: string,
  code: ErrorCode = 'poisoned',
): Promise<T> {
  started ??= startDecoder({ module_or_path: module });
  await started;
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
 * A mask at the size of its picture: `labels` holds the label of each pixel, `alpha` how opaque the chosen objects are
 * there, 0 not at all to 255 fully: from 128 on exactly where the label is one of theirs, soft where the picture goes
 * softly from one to the other, and 0 or 255 away from their borders.
 */
export type EnlargedMask = {
  readonly width: number;
  readonly height: number;
  readonly labels: Uint8Array<ArrayBuffer>;
  readonly alpha: Uint8Array<ArrayBuffer>;
};

/** A picture that a worker reads: to do so takes long enough to be felt where pages are drawn. */
export type Image = { kind: 'image'; image: VideoFrame | ImageBitmap };

/** A mask and its picture on their way, in memory that nobody else holds. */
export type EnlargeTask = {
  labels: Uint8Array<ArrayBuffer>;
  width: number;
  picture: RawFrame | Image;
  chosen: Uint8Array<ArrayBuffer>;
  module: WebAssembly.Module;
};

/** Enlarges in this thread. */
export async function enlargeHere({ labels, width, picture, chosen, module }: EnlargeTask): Promise<EnlargedMask> {
  const pixels = await pixelsOf(picture);
  const call = () => enlarge(labels, width, pixels.data, pixels.width, pixels.height, chosen);
  const [large, alpha] = await callDecoder(module, call, 'the mask cannot be enlarged');
  return { width: pixels.width, height: pixels.height, labels: large, alpha };
}

async function pixelsOf(picture: EnlargeTask['picture']) {
  if (picture.kind !== 'image') return toPixels(picture);
  try {
    return await toPixels(await fromImage(picture.image));
  } finally {
    picture.image.close();
  }
}
