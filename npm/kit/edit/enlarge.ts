// Masks at the size of the source: what the caller gives, and the workers that it goes to where there are workers.

import { TraceCutError, checkSides, checkedOptions, illegal, typeTag } from '../../check/errors.js';
import { type ObjectChoice, chosenLabels } from '../../check/masks.js';
import { type WasmSource, checkWorker } from '../../check/options.js';
import { platform, workerStarter } from '../../platform.js';
import { type EnlargeTask, type EnlargedMask, type Image, enlargeHere } from '../../worker/decode.js';
import { type FrameSource, toRawFrame } from '../../worker/frames.js';
import { TaskWorkers } from '../../worker/remote.js';
import type { WorkerSource } from '../../places.js';

/** A mask of one frame: a label for each pixel, row by row, 0 for the background. */
export type FrameMask = { labels: Uint8Array; width: number; height: number };

/** Options of enlarging. */
export interface EnlargeOptions {
  /** The labels whose opacity is wanted, all objects if not given, also such that this frame does not have. */
  objects?: ObjectChoice;
  /** Where the wasm file is that enlarges, when not beside the package. */
  decoder?: WasmSource;
  /** False to work on the calling thread (Node does so unless it is true), or where the worker is. */
  worker?: boolean | WorkerSource;
}

/** Most workers at once: each holds a picture and its masks. */
const MOST_WORKERS = 4;

/**
 * A mask at the size of its picture, which is larger than the mask or as large: borders come to where the picture parts
 * its colours, and are as soft as they are there. In browsers it runs in a worker, as many at once as there are cores, four
 * at most; in Node on the calling thread.
 *
 * ```js
 * const { width, height, labels, alpha } = await enlargeMask({ labels, width: 480, height: 270 }, bitmap);
 * ```
 * @param mask at the size that frames were processed at
 * @param picture the frame as it was before it was reduced
 */
export async function enlargeMask(
  mask: FrameMask,
  picture: FrameSource,
  options?: EnlargeOptions,
): Promise<EnlargedMask> {
  const { objects, decoder, worker } = checkedOptions(options ?? {}, ['objects', 'decoder', 'worker']);
  if (worker !== undefined) checkWorker(worker);
  const startWorker = workerStarter(worker);
  const chosen = new Uint8Array(chosenLabels(objects));
  const { labels, width } = copied(mask);
  const load = () => platform.loadDecoder(decoder);
  const held = (startWorker && image(picture)) ?? toRawFrame(picture, load);
  const [raw, module] = await Promise.all([held, load()]);
  const task: EnlargeTask = { labels, width, picture: raw, chosen, module };
  if (!startWorker) return enlargeHere(task);
  return workers.give(startWorker, (remote) => remote.send({ type: 'enlarge', data: task }));
}

/** A copy of a picture that the browser holds, taken before this returns; nothing where it is none, or empty. */
function image(picture: FrameSource): Promise<Image> | undefined {
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
function copied(mask: FrameMask) {
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

/** They are shared by all calls. */
const workers = new TaskWorkers(enlargedAtOnce);

/** Returns the number of masks that workers enlarge at once; 0 where none do. */
export function enlargedAtOnce(): number {
  return workerStarter(undefined) ? Math.min(MOST_WORKERS, platform.cores() ?? 1) : 0;
}
