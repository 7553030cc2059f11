// Enlarges masks to the size of the source: checks the arguments and hands the work to workers, if there are any.

import { TraceCutError, checkOptions, checkSides, illegal, typeTag } from '../../check/errors.js';
import { type ObjectChoice, selectLabels } from '../../check/masks.js';
import { type WasmSource, checkWorker } from '../../check/options.js';
import { type WorkerSource, getWorkerStarter, platform } from '../../platform.js';
import {
  type EnlargeTask,
  type EnlargedFrame,
  type EnlargedMask,
  type HeldImage,
  enlargeInThread,
} from '../../worker/instance.js';
import { type FrameSource, toRawFrame } from '../../worker/frames.js';
import { TaskWorkers } from '../../worker/remote.js';

/** A mask of one frame: a label for each pixel, row by row, 0 for the background. */
export type FrameMask = { labels: Uint8Array; width: number; height: number };

/** Options of enlarging. */
export interface EnlargeOptions {
  /** Labels whose opacity is returned, also those absent from this frame; all objects if not given. */
  objects?: ObjectChoice;
  /** The wasm file that enlarges, if it is not beside the package. */
  decoder?: WasmSource;
  /** False to work on the calling thread (the default in Node), or the source of the worker. */
  worker?: boolean | WorkerSource;
}

/** Most workers at once: each holds a picture and its masks. */
const MAX_WORKERS = 4;

/**
 * Enlarges a mask to the size of its picture, which is at least as large: borders move to the picture's colour edges and
 * become as soft as they are. In browsers it runs in workers, one for each core, at most four; in Node on the calling
 * thread.
 *
 * ```js
 * const { width, height, labels, alpha } = await enlargeMask({ labels, width: 480, height: 270 }, bitmap);
 * ```
 * @param mask at the size that frames were processed at
 * @param picture the frame before it was reduced
 */
export async function enlargeMask(
  mask: FrameMask,
  picture: FrameSource,
  options?: EnlargeOptions,
): Promise<EnlargedMask> {
  const { width, height, labels, alpha } = await enlargeFrame(mask, picture, false, options);
  return { width, height, labels, alpha };
}

/**
 * Enlarges a mask as `enlargeMask` does.
 * @param readsPicture true to return the picture's pixels too, which are read anyway
 */
export async function enlargeFrame(
  mask: FrameMask,
  picture: FrameSource,
  readsPicture: boolean,
  options?: EnlargeOptions,
): Promise<EnlargedFrame> {
  const { objects, decoder, worker } = checkOptions(options ?? {}, ['objects', 'decoder', 'worker']);
  if (worker !== undefined) checkWorker(worker);
  const startWorker = getWorkerStarter(worker);
  const selected = new Uint8Array(selectLabels(objects));
  const { labels, width } = copyMask(mask);
  const load = () => platform.loadDecoder(decoder);
  const copying = (startWorker && copyImage(picture)) ?? toRawFrame(picture, load);
  const [raw, module] = await Promise.all([copying, load()]);
  const task: EnlargeTask = { labels, width, picture: raw, chosen: selected, readsPicture, module };
  if (!startWorker) return enlargeInThread(task);
  return workers.give(startWorker, (remote) => remote.send({ type: 'enlarge', data: task }));
}

/** Copies a picture that the browser holds before this returns; undefined for other sources and empty pictures. */
function copyImage(picture: FrameSource): Promise<HeldImage> | undefined {
  switch (typeTag(picture)) {
    case 'VideoFrame': {
      const frame = picture as VideoFrame;
      return frame.codedWidth > 0 ? Promise.resolve({ kind: 'image', image: frame.clone() }) : undefined;
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas': {
      const bitmap = picture as ImageBitmap;
      if (bitmap.width === 0 || bitmap.height === 0) return undefined;
      return createImageBitmap(bitmap).then((copy) => ({ kind: 'image', image: copy }));
    }
    default:
      return undefined;
  }
}

/** Copies a mask, so that the caller may change it at once. */
function copyMask(mask: FrameMask) {
  if (typeof mask !== 'object' || mask === null)
    throw illegal('data', 'mask', mask, 'an object {labels, width, height}');
  checkSides('data', 'mask.', mask);
  const { labels, width, height } = mask;
  if (!(labels instanceof Uint8Array || (labels as unknown) instanceof Uint8ClampedArray))
    throw illegal('data', 'mask.labels', labels, 'a Uint8Array, a label for each pixel');
  if (labels.length !== width * height)
    throw new TraceCutError('data', `mask.labels has ${labels.length} labels (expected ${width * height})`);
  return { labels: new Uint8Array(labels), width };
}

/** Shared by all calls. */
const workers = new TaskWorkers(countParallelEnlargements);

/** Returns the number of masks that workers enlarge at once; 0 without workers. */
export function countParallelEnlargements(): number {
  return getWorkerStarter(undefined) ? Math.min(MAX_WORKERS, platform.cores() ?? 1) : 0;
}
