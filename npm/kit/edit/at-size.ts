// Masks at the size of the pictures that they cover, and the pixels of these pictures.

import { TraceCutError, checkOptions, illegal, typeTag } from '../../check/errors.js';
import { type MaskSource, checkMasks, getTimes, readLabels, selectLabels } from '../../check/masks.js';
import { getWorkerStarter } from '../../platform.js';
import { type Runs, decodeRuns, encodeRuns } from '../../session/serialize.js';
import { toPixels } from '../../worker/instance.js';
import { type FrameSource, type PixelFrame, fromImage } from '../../worker/frames.js';
import { yieldThread } from '../../worker/pause.js';
import { type Mask, type MaskEdges, checkEdges, computeAlpha, growObjects, removeSpecks } from './adjust.js';
import { countParallelEnlargements, enlargeFrame } from './enlarge.js';
import type { WasmSource } from '../../check/options.js';
import type { ExportProgress } from '../export/masks.js';
import type { EncodeFrames, EncodeItem } from '../export/video.js';

/** `labels` holds a label for each pixel, `alpha` the opacity of the selected objects there, 0 to 255. */
export type MaskAtSize = {
  width: number;
  height: number;
  labels: Uint8Array;
  alpha: Uint8Array<ArrayBuffer>;
  /** RGBA pixels of the picture, if they were requested and had to be read for the mask. */
  picture?: Uint8Array<ArrayBuffer>;
};

/** Options of `masksAtSize`. */
export interface MasksAtSizeOptions {
  /** Called for each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Removes specks, grows or shrinks objects; `feather` has no effect here. */
  edges?: MaskEdges;
  /** As for a session. */
  decoder?: WasmSource;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

/**
 * Enlarges masks to the size of their frames, for exports at the size of the source: frames are read one by one, borders
 * move to the picture's own edges (`enlargeMask`), masks are kept as runs of equal labels. All frames have one size.
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
  const { onProgress, signal, edges, decoder } = checkOptions(options ?? {}, legal);
  const adjustments = checkEdges(edges);
  const { numFrames, shots, end } = masks;
  const times = getTimes(masks);
  const selected = selectLabels(undefined);
  const size = { width: 0, height: 0 };
  const runs: Runs[] = [];
  const take = async (item: EncodeItem, t: number) => {
    signal?.throwIfAborted();
    const { picture, close } = await keepPicture(item, t);
    if (t === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, t);
    const { width, height } = masks;
    const mask = { labels: readLabels(masks, t), width, height };
    return { picture: null, mask: scaleMask(mask, picture.source, selected, adjustments, decoder), close };
  };
  for await (const { mask } of prefetch(frames, numFrames, take)) {
    signal?.throwIfAborted();
    runs.push(encodeRuns(mask.labels));
    onProgress?.({ done: runs.length, total: numFrames });
    await yieldThread();
  }
  if (runs.length < numFrames) throw createTooFewError(runs.length, numFrames);
  return {
    ...size,
    numFrames,
    times,
    end: end ?? null,
    ...(Array.isArray(shots) ? { shots } : {}),
    labels: (t) => decodeRuns(runs[t]!),
  };
}

/**
 * Pixels by which a mask's shape may differ from the picture's, as sizes are rounded. `enlargeMask` has the same limit.
 */
const SHAPE_TOLERANCE_PX = 2;

/**
 * Returns a mask at the size of a picture, its edges adjusted: specks are removed first, so that they do not grow;
 * borders move to the picture's own edges; lengths are scaled with the mask.
 */
export async function scaleMask(
  mask: Mask,
  picture: VideoFrame | (FrameSource & { width: number; height: number }),
  selected: Uint8Array,
  { smallest, grow, feather }: Required<MaskEdges>,
  decoder?: WasmSource,
  readsPicture = false,
): Promise<MaskAtSize> {
  const { width, height } = 'displayWidth' in picture ? getDisplaySize(picture) : picture;
  const clean = removeSpecks(mask, selected, smallest);
  const [only = 0] = clean.labels;
  if (clean.labels.every((label) => label === only)) {
    const filledWith = (value: number) => {
      const values = new Uint8Array(width * height);
      return value > 0 ? values.fill(value) : values;
    };
    return { width, height, labels: filledWith(only), alpha: filledWith(selected[only] ? 255 : 0) };
  }
  const [across, down] = [width / mask.width, height / mask.height];
  const scale = Math.sqrt(across * down);
  // If the picture has another shape than the mask, it cannot guide the borders.
  const hasOtherShape =
    Math.min(Math.abs(mask.height - height / across), Math.abs(mask.width - width / down)) > SHAPE_TOLERANCE_PX;
  const hasPicture = across > 1 && down > 1 && !hasOtherShape;
  const objects = (label: number) => selected[label] === 1;
  const enlarged = hasPicture ? await enlargeFrame(clean, picture, readsPicture, { objects, decoder }) : null;
  const isSameSize = across === 1 && down === 1;
  const labels = enlarged?.labels ?? (isSameSize ? clean.labels : scaleNearest(clean, width, height));
  // As soft as the picture, unless other edges are requested.
  const pixels = enlarged?.picture;
  if (enlarged && grow === 0 && feather === 0) return { width, height, labels, alpha: enlarged.alpha, picture: pixels };
  const adjusted = growObjects({ labels, width, height }, selected, scale * grow);
  return { ...adjusted, alpha: computeAlpha(adjusted, selected, scale * feather), picture: pixels };
}

/** Scales a mask by nearest neighbour. */
function scaleNearest(mask: Mask, width: number, height: number) {
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

export function createTooFewError(count: number, expected: number) {
  return new TraceCutError(
    'data',
    `the frames ended after ${count} of ${expected} (expected one for each frame of the masks)`,
  );
}

const getDisplaySize = ({ displayWidth, displayHeight }: VideoFrame) => ({
  width: displayWidth,
  height: displayHeight,
});

/** An image that a canvas can draw; `close` frees it if it was made from a frame. */
export type Drawable = { image: CanvasImageSource; width: number; height: number; close?: () => void };

export function getContext2d(canvas: OffscreenCanvas) {
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser cannot create a 2D canvas');
  return context;
}

export async function toDrawable(item: EncodeItem, t: number): Promise<Drawable> {
  const frame = unwrapItem(item);
  switch (typeTag(frame)) {
    case 'VideoFrame': {
      const image = frame as VideoFrame;
      return { image, ...getDisplaySize(image) };
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
      return drawableFromPixels(frame, t);
  }
}

async function drawableFromPixels(frame: unknown, t: number): Promise<Drawable> {
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

/** Returns the pixels as RGBA; RGBA pixels are not copied. */
export async function readPixels(item: EncodeItem, t: number): Promise<PixelFrame> {
  const frame = unwrapItem(item);
  const { data, width, height } = (frame ?? {}) as Partial<PixelFrame>;
  if (ArrayBuffer.isView(data) && Number(width) > 0 && data.length === 4 * Number(width) * Number(height))
    return frame as PixelFrame;
  // The decoder's own colours: a canvas may change them.
  if (typeTag(frame) === 'VideoFrame') return toPixels(await fromImage(frame as VideoFrame));
  if (typeof OffscreenCanvas === 'undefined')
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      '{data, width, height} in RGBA: this engine has no canvas to draw it on',
    );
  const drawable = await toDrawable(item, t);
  try {
    const context = getContext2d(new OffscreenCanvas(drawable.width, drawable.height));
    context.drawImage(drawable.image, 0, 0, drawable.width, drawable.height);
    return context.getImageData(0, 0, drawable.width, drawable.height);
  } finally {
    drawable.close?.();
  }
}

/**
 * Keeps a picture that a mask is enlarged to: a `VideoFrame` as it is, for a worker to read, and the pixels of all others.
 * `close` frees it.
 */
export async function keepPicture(item: EncodeItem, t: number) {
  const frame = unwrapItem(item);
  if (typeTag(frame) !== 'VideoFrame' || !getWorkerStarter(undefined)) {
    const source = await readPixels(item, t);
    const { width, height } = source;
    return { picture: { source, width, height }, close: () => {} };
  }
  const source = (frame as VideoFrame).clone();
  return { picture: { source, ...getDisplaySize(source) }, close: () => source.close() };
}

function unwrapItem(item: EncodeItem) {
  return typeTag(item) === 'Object' && 'frame' in item ? item.frame : item;
}

/** A frame's picture and its mask, which is still being computed; `close` frees the picture. */
export type PendingFrame<P> = { picture: P; mask: Promise<MaskAtSize>; close?: () => void };

/**
 * Yields frames with their masks, in order. As many frames are prepared ahead as are enlarged at once; no frame is read
 * beyond the last.
 * @param count number of frames
 * @param take copies what it needs of an item: the next item may be the same object
 * @returns a picture is valid until the next one is requested
 */
export async function* prefetch<I, P>(
  items: Iterable<I> | AsyncIterable<I>,
  count: number,
  take: (item: I, t: number) => Promise<PendingFrame<P>>,
): AsyncGenerator<{ picture: P; mask: MaskAtSize }, void, undefined> {
  const waiting: PendingFrame<P>[] = [];
  const maxWaiting = countParallelEnlargements();
  async function* first() {
    const [{ picture, mask }] = waiting as [PendingFrame<P>];
    yield { picture, mask: await mask };
    waiting.shift()?.close?.();
  }
  try {
    let t = 0;
    for await (const item of items) {
      const pending = await take(item, t);
      // Its error is thrown when its turn comes.
      pending.mask.catch(() => {});
      waiting.push(pending);
      t += 1;
      if (t === count) break;
      if (waiting.length > maxWaiting) yield* first();
    }
    while (waiting.length > 0) yield* first();
  } finally {
    for (const { close } of waiting) close?.();
  }
}
