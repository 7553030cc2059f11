// Masks at the size of the pictures that they are laid over, and the pixels of these.

import { TraceCutError, checkedOptions, illegal, typeTag } from '../../check/errors.js';
import { type MaskSource, checkMasks, chosenLabels, labelsOf, timesOf } from '../../check/masks.js';
import { type Runs, decodeRuns, encodeRuns } from '../../session/runs.js';
import { toPixels } from '../../worker/decode.js';
import { type FrameSource, type PixelFrame, fromImage } from '../../worker/frames.js';
import { breath } from '../../worker/pause.js';
import { type Mask, type MaskEdges, checkedEdges, grown, softAlpha, withoutSpecks } from './adjust.js';
import { ahead } from './ahead.js';
import { enlargeMask } from './enlarge.js';
import type { WasmSource } from '../../check/options.js';
import type { ExportProgress } from '../export/masks.js';
import type { EncodeFrames, EncodeItem } from '../export/video.js';

/** `labels` holds a label for each pixel, `alpha` how opaque the chosen objects are there, 0 to 255. */
export type MaskAtSize = { width: number; height: number; labels: Uint8Array; alpha: Uint8Array<ArrayBuffer> };

export interface MasksAtSizeOptions {
  /** Told of each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Specks left out, objects grown or shrunk; `feather` is of no meaning here. */
  edges?: MaskEdges;
  /** As for a session. */
  decoder?: WasmSource;
  /** Ends the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

/**
 * Masks at the size of their frames, for exports at the size of the source: frames are read one by one, borders come to
 * where they have them (`enlargeMask`), masks are kept as runs of equal labels. All frames have one size.
 * @param frames one for each frame of the masks, in order
 * @returns with the times and shots of `masks`
 */
export async function masksAtSize(
  masks: MaskSource,
  frames: EncodeFrames,
  options?: MasksAtSizeOptions,
): Promise<MaskSource> {
  checkMasks(masks);
  const legal = ['onProgress', 'signal', 'edges', 'decoder'];
  const { onProgress, signal, edges, decoder } = checkedOptions(options ?? {}, legal);
  const how = checkedEdges(edges);
  const { numFrames, shots, end } = masks;
  const times = timesOf(masks);
  const all = chosenLabels(undefined);
  const size = { width: 0, height: 0 };
  const runs: Runs[] = [];
  const take = async (item: EncodeItem, t: number) => {
    signal?.throwIfAborted();
    const picture = await pixelsOf(item, t);
    if (t === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, t);
    const { width, height } = masks;
    const mask = maskAtSize({ labels: labelsOf(masks, t), width, height }, picture, all, how, decoder);
    return { picture: null, mask };
  };
  for await (const { mask } of ahead(frames, numFrames, take)) {
    signal?.throwIfAborted();
    runs.push(encodeRuns(mask.labels));
    onProgress?.({ done: runs.length, total: numFrames });
    await breath();
  }
  if (runs.length < numFrames) throw tooFew(runs.length, numFrames);
  return {
    ...size,
    numFrames,
    times,
    end: end ?? null,
    ...(Array.isArray(shots) ? { shots } : {}),
    labels: (t) => decodeRuns(runs[t]!),
  };
}

/** How many of its pixels a mask's shape may differ from the picture's, as `enlargeMask` has it: sizes are rounded. */
const SHAPE_TOLERANCE = 2;

/**
 * A mask at the size of a picture, its edges as they are wanted: specks are left out first, so that they grow nowhere;
 * borders come to where the picture has them; lengths are scaled with the mask.
 */
export async function maskAtSize(
  mask: Mask,
  picture: VideoFrame | (FrameSource & { width: number; height: number }),
  chosen: Uint8Array,
  { smallest, grow, feather }: Required<MaskEdges>,
  decoder?: WasmSource,
): Promise<MaskAtSize> {
  const { width, height } = 'displayWidth' in picture ? sizeOf(picture) : picture;
  const clean = withoutSpecks(mask, chosen, smallest);
  const [only = 0] = clean.labels;
  if (clean.labels.every((label) => label === only)) {
    const filled = (value: number) => new Uint8Array(width * height).fill(value);
    return { width, height, labels: filled(only), alpha: filled(chosen[only] ? 255 : 0) };
  }
  const [across, down] = [width / mask.width, height / mask.height];
  const scale = Math.sqrt(across * down);
  // Where the picture shows something else than the mask, its borders are of no use.
  const isOther =
    Math.min(Math.abs(mask.height - height / across), Math.abs(mask.width - width / down)) > SHAPE_TOLERANCE;
  const hasPicture = across > 1 && down > 1 && !isOther;
  const objects = (label: number) => chosen[label] === 1;
  const found = hasPicture ? await enlargeMask(clean, picture, { objects, decoder }) : null;
  const isLike = across === 1 && down === 1;
  const labels = found?.labels ?? (isLike ? clean.labels : nearest(clean, width, height));
  // As soft as the picture, unless something else is wanted.
  if (found && grow === 0 && feather === 0) return { width, height, labels, alpha: found.alpha };
  const large = grown({ labels, width, height }, chosen, scale * grow);
  return { ...large, alpha: softAlpha(large, chosen, scale * feather) };
}

/** Each pixel has the label of the mask's pixel in which its centre lies. */
function nearest(mask: Mask, width: number, height: number) {
  const labels = new Uint8Array(width * height);
  const columns = Uint32Array.from({ length: width }, (_, x) => Math.floor(((x + 0.5) * mask.width) / width));
  for (let y = 0, p = 0; y < height; y += 1) {
    const row = mask.width * Math.floor(((y + 0.5) * mask.height) / height);
    for (let x = 0; x < width; x += 1, p += 1) labels[p] = mask.labels[row + Number(columns[x])]!;
  }
  return labels;
}

export function checkSize(
  frame: { width: number; height: number },
  size: { width: number; height: number },
  t: number,
) {
  if (frame.width === size.width && frame.height === size.height) return;
  throw new TraceCutError(
    'frame-size-changed',
    `frame ${t} is ${frame.width} × ${frame.height} pixels (expected ${size.width} × ${size.height}, as the first)`,
  );
}

export function tooFew(count: number, expected: number) {
  return new TraceCutError(
    'data',
    `the frames ended after ${count} of ${expected} (expected one for each frame of the masks)`,
  );
}

const sizeOf = ({ displayWidth, displayHeight }: VideoFrame) => ({ width: displayWidth, height: displayHeight });

/** What a canvas can draw; `close` where it was made of a frame and is to be let go. */
export type Drawable = { image: CanvasImageSource; width: number; height: number; close?: () => void };

export function context2d(canvas: OffscreenCanvas) {
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser gave no 2d canvas to paint frames on');
  return context;
}

export async function drawable(item: EncodeItem, t: number): Promise<Drawable> {
  const frame = unwrapped(item);
  switch (typeTag(frame)) {
    case 'VideoFrame': {
      const image = frame as VideoFrame;
      return { image, ...sizeOf(image) };
    }
    case 'HTMLVideoElement': {
      const image = frame as HTMLVideoElement;
      return { image, width: image.videoWidth, height: image.videoHeight };
    }
    case 'HTMLImageElement': {
      const image = frame as HTMLImageElement;
      return { image, width: image.naturalWidth, height: image.naturalHeight };
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas': {
      const image = frame as ImageBitmap;
      return { image, width: image.width, height: image.height };
    }
    case 'Blob':
    case 'File': {
      const image = await createImageBitmap(frame as Blob);
      return { image, width: image.width, height: image.height, close: () => image.close() };
    }
    default:
      return fromPixels(frame, t);
  }
}

async function fromPixels(frame: unknown, t: number): Promise<Drawable> {
  const { data, width, height } = (frame ?? {}) as Partial<PixelFrame>;
  if (!ArrayBuffer.isView(data) || !(Number(width) > 0) || data.length !== 4 * Number(width) * Number(height)) {
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      'something a canvas can draw, ImageData, {data, width, height} in RGBA, or a Blob of an image',
    );
  }
  const pixels =
    typeTag(frame) === 'ImageData' ? frame : new ImageData(new Uint8ClampedArray(data), Number(width), Number(height));
  const image = await createImageBitmap(pixels as ImageData);
  return { image, width: image.width, height: image.height, close: () => image.close() };
}

/** Returns the pixels as RGBA; those that are RGBA already are not copied. */
export async function pixelsOf(item: EncodeItem, t: number): Promise<PixelFrame> {
  const frame = unwrapped(item);
  const { data, width, height } = (frame ?? {}) as Partial<PixelFrame>;
  if (ArrayBuffer.isView(data) && Number(width) > 0 && data.length === 4 * Number(width) * Number(height))
    return frame as PixelFrame;
  // As the decoder has it: a canvas may change it.
  if (typeTag(frame) === 'VideoFrame') return toPixels(await fromImage(frame as VideoFrame));
  if (typeof OffscreenCanvas === 'undefined')
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      '{data, width, height} in RGBA: this engine has no canvas to draw it on',
    );
  const found = await drawable(item, t);
  try {
    const context = context2d(new OffscreenCanvas(found.width, found.height));
    context.drawImage(found.image, 0, 0, found.width, found.height);
    return context.getImageData(0, 0, found.width, found.height);
  } finally {
    found.close?.();
  }
}

function unwrapped(item: EncodeItem) {
  return typeTag(item) === 'Object' && 'frame' in item ? item.frame : item;
}
