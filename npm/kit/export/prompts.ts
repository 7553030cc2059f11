// Prompts for models that follow an object, such as SAM 2: the frame that shows the object best, its box, points and mask.

import { checkOptions } from '../../check/errors.js';
import { checkMasks, getFirstFrame, getTimes, readLabels, selectLabels } from '../../check/masks.js';
import { Prompts } from '../../decoder.js';
import { VERSION } from '../../parameters.js';
import { platform } from '../../platform.js';
import { callDecoder } from '../../worker/decode.js';
import { yieldThread } from '../../worker/pause.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';
import type { WasmSource } from '../../check/options.js';

/**
 * A prompt that selects an object, with the field names of SAM 2's video predictor, in pixels: `box` is left, top, right
 * and bottom; `points` are `[x, y]`, with 1 in `labels` for points on the object and 0 for points beside it; `mask` holds
 * the object's largest connected part as COCO run lengths. `obj_id` is the label, `frame_idx` the frame that shows it
 * best.
 */
export type ObjectPrompt = {
  obj_id: number;
  frame_idx: number;
  box: number[];
  points: number[][];
  labels: number[];
  mask: { size: [number, number]; counts: string };
};

/** Options of `prompts`. */
export interface PromptsOptions {
  /** Objects to prompt for; all but the background if not given. */
  objects?: ObjectChoice;
  /** The file `decoder_bg.wasm`, if it is not beside the package. */
  decoder?: WasmSource;
}

/**
 * The prompts of a clip, with the size of its masks in pixels, and the times of its frames (of a window's frames for a
 * window) in seconds, if known.
 */
export type PromptList = {
  info: { description: string; version: string };
  width: number;
  height: number;
  prompts: ObjectPrompt[];
  times?: number[];
};

type PromptRow = [
  object: number,
  frame: number,
  box: Uint32Array,
  inside: Uint32Array,
  outside: Uint32Array,
  counts: string,
];

/** Frames between two pauses for the page's thread. */
const BATCH = 8;

/**
 * Returns a prompt for each object, for models that follow an object from a click, a box or a mask. Points lie as deep in
 * the object, and as far from it, as possible; docs/interchange.md shows how to pass them to SAM 2, SAM 3 and ComfyUI.
 *
 * ```js
 * const json = JSON.stringify(await prompts(result));
 * ```
 * @returns for `JSON.stringify`; prompts by their objects, ascending
 */
export async function prompts(masks: MaskSource, options: PromptsOptions = {}): Promise<PromptList> {
  checkMasks(masks);
  const { objects, decoder } = checkOptions(options, ['objects', 'decoder']);
  const selected = selectLabels(objects);
  const { width, height, numFrames } = masks;
  const times = getTimes(masks);
  const module = await platform.loadDecoder(decoder);
  const call = <T>(work: () => T) => callDecoder(module, work, 'prompts cannot be made');
  const collector = await call(() => new Prompts());
  for (let t = 0; t < numFrames; t += 1) {
    if (t % BATCH === BATCH - 1) await yieldThread();
    const labels = readLabels(masks, t);
    await call(() => collector.add(getFirstFrame(masks) + t, labels, width, selected));
  }
  const entries: PromptRow[] = await call(() => collector.finish());
  return {
    info: { description: 'Prompts for objects that TraceCut found', version: VERSION },
    width,
    height,
    prompts: entries.map(([object, frame, box, inside, outside, counts]) => ({
      obj_id: object,
      frame_idx: frame,
      box: Array.from(box),
      points: [...toPairs(inside), ...toPairs(outside)],
      labels: [...toPairs(inside).map(() => 1), ...toPairs(outside).map(() => 0)],
      mask: { size: [height, width], counts },
    })),
    ...(times && { times: [...times] }),
  };
}

function toPairs(places: Uint32Array) {
  return Array.from({ length: places.length / 2 }, (_, k) => [Number(places[2 * k]), Number(places[2 * k + 1])]);
}
