// Masks at the size of the source: what the caller gives, and the workers that it goes to where there are workers.

import { TraceCutError, checkedOptions, illegal, typeTag, wholeNumber } from '../../check/errors.js';
import { chosenLabels } from '../../check/masks.js';
import { checkWorker } from '../../check/options.js';
import { platform, workerStarter } from '../../platform.js';
import { enlargeHere } from '../../worker/decode.js';
import { toRawFrame } from '../../worker/frames.js';
import { RemoteEngine } from '../../worker/remote.js';

/**
 * A mask of one frame: a label for each pixel, row by row, 0 for the background.
 * @typedef {{labels: Uint8Array, width: number, height: number}} FrameMask
 */

/** @typedef {import('../../worker/decode.js').EnlargeTask} EnlargeTask */
/** @typedef {import('../../worker/decode.js').EnlargedMask} EnlargedMask */
/** @typedef {import('../../worker/decode.js').Image} Image */

/**
 * Options of enlarging.
 * @typedef {object} EnlargeOptions
 * @property {import('../../check/masks.js').ObjectChoice} [objects] the labels whose opacity is wanted, all objects
 *   if not given, also such that this frame does not have
 * @property {import('../../check/options.js').WasmSource} [decoder] where the wasm file is that enlarges, when not beside the
 *   package
 * @property {boolean | import('../../places.js').WorkerSource} [worker] false to work on the calling thread (Node does so
 *   unless it is true), or where the worker is
 */

const MAX_SIDE = 16384;
/** How long workers stay that have nothing to do: frames of a clip come one after the other. */
const IDLE_MS = 5000;
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
 * @param {FrameMask} mask at the size that frames were processed at
 * @param {import('../../worker/frames.js').FrameSource} picture the frame as it was before it was reduced
 * @param {EnlargeOptions} [options]
 * @returns {Promise<import('../../worker/decode.js').EnlargedMask>}
 */
export async function enlargeMask(mask, picture, options) {
  const { objects, decoder, worker } = checkedOptions(options ?? {}, ['objects', 'decoder', 'worker']);
  if (worker !== undefined) checkWorker(worker);
  const startWorker = workerStarter(worker);
  const chosen = new Uint8Array(chosenLabels(objects));
  const { labels, width } = copied(mask);
  const load = () => platform.loadDecoder(decoder);
  const held = (startWorker && image(picture)) ?? toRawFrame(picture, load);
  const [raw, module] = await Promise.all([held, load()]);
  /** @type {EnlargeTask} */
  const task = { labels, width, picture: raw, chosen, module };
  return startWorker ? inWorker(task, startWorker) : enlargeHere(task);
}

/**
 * A copy of a picture that the browser holds, taken before this returns; nothing where it is none, or empty.
 * @param {import('../../worker/frames.js').FrameSource} picture
 * @returns {Promise<Image> | undefined}
 */
function image(picture) {
  switch (typeTag(picture)) {
    case 'VideoFrame': {
      const frame = /** @type {VideoFrame} */ (picture);
      return frame.codedWidth > 0 ? Promise.resolve({ kind: 'image', image: frame.clone() }) : undefined;
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas': {
      const bitmap = /** @type {ImageBitmap} */ (picture);
      if (bitmap.width === 0 || bitmap.height === 0) return undefined;
      return createImageBitmap(bitmap).then((copy) => ({ kind: 'image', image: copy }));
    }
    default:
      return undefined;
  }
}

/**
 * Copies a mask, so that the caller may change it at once.
 * @param {FrameMask} mask
 */
function copied(mask) {
  if (typeof mask !== 'object' || mask === null)
    throw illegal('data', 'mask', mask, 'an object {labels, width, height}');
  const width = wholeNumber('data', 'mask.width', mask.width, 1, MAX_SIDE);
  const height = wholeNumber('data', 'mask.height', mask.height, 1, MAX_SIDE);
  const { labels } = mask;
  if (!(labels instanceof Uint8Array || /** @type {unknown} */ (labels) instanceof Uint8ClampedArray))
    throw illegal('data', 'mask.labels', labels, 'a Uint8Array, a label for each pixel');
  if (labels.length !== width * height)
    throw new TraceCutError('data', `mask.labels has ${labels.length} labels (expected ${width * height})`);
  return { labels: new Uint8Array(labels), width };
}

/** @typedef {{engine: RemoteEngine, underWay: number}} Enlarger */

/** @type {Enlarger[]} */
let enlargers = [];
/** @type {ReturnType<typeof setTimeout> | undefined} */
let ending;

/** @returns {number} how many masks workers enlarge at once; 0 where none do it if nobody asks for one */
export function enlargedAtOnce() {
  return workerStarter(undefined) ? Math.min(MOST_WORKERS, platform.cores() ?? 1) : 0;
}

/**
 * Enlarges in a worker, which all calls share; its memory goes with it.
 * @param {EnlargeTask} task
 * @param {() => Worker} startWorker
 */
async function inWorker(task, startWorker) {
  clearTimeout(ending);
  const mine = freest(startWorker);
  mine.underWay += 1;
  try {
    return await mine.engine.enlarge(task);
  } catch (error) {
    // A worker that could not start, or was lost, is of no more use; one that refuses a mask is.
    if (mine.engine.ended) enlargers = enlargers.filter((one) => one !== mine);
    throw error;
  } finally {
    mine.underWay -= 1;
    if (enlargers.every(({ underWay }) => underWay === 0)) ending = setTimeout(end, IDLE_MS);
  }
}

/**
 * One that has nothing to do, a new one where all have and there may be more, else the one with the least.
 * @param {() => Worker} startWorker
 */
function freest(startWorker) {
  const [first] = [...enlargers].sort((a, b) => a.underWay - b.underWay);
  if (first && (first.underWay === 0 || enlargers.length >= Math.max(1, enlargedAtOnce()))) return first;
  const made = { engine: new RemoteEngine(startWorker()), underWay: 0 };
  enlargers.push(made);
  return made;
}

function end() {
  for (const { engine } of enlargers) engine.close();
  enlargers = [];
}
