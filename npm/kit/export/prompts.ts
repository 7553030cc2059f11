// Prompts for models that follow an object from a hint, such as SAM 2: which frame shows it best, its box, points and mask.

import { checkedOptions } from '../../check/errors.js';
import { checkMasks, chosenLabels, firstOf, labelsOf, timesOf } from '../../check/masks.js';
import { Prompts } from '../../decoder.js';
import { VERSION } from '../../parameters.js';
import { platform } from '../../platform.js';
import { callDecoder } from '../../worker/decode.js';
import { breath } from '../../worker/pause.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';
import type { WasmSource } from '../../check/options.js';

/**
 * What tells a promptable model which object is meant, under the names that SAM 2's video predictor has for it, in pixels:
 * `box` is left, top, right and bottom; `points` are `[x, y]`, of which `labels` says 1 for on the object and 0 for beside it;
 * `mask` holds the object's largest connected part as COCO run lengths. `obj_id` is the label, `frame_idx` the frame that shows it best.
 */
export type ObjectPrompt = {
  obj_id: number;
  frame_idx: number;
  box: number[];
  points: number[][];
  labels: number[];
  mask: { size: [number, number]; counts: string };
};

export interface PromptsOptions {
  /** All but the background if not given. */
  objects?: ObjectChoice;
  /** Where `decoder_bg.wasm` is, when not beside the package. */
  decoder?: WasmSource;
}

/**
 * The prompts of a clip, with the size of its masks in pixels, and the times of its frames (of a window: of its own) in
 * seconds, where they are known.
 */
export type PromptList = {
  info: { description: string; version: string };
  width: number;
  height: number;
  prompts: ObjectPrompt[];
  times?: number[];
};

export type Entry = [
  object: number,
  frame: number,
  box: Uint32Array,
  inside: Uint32Array,
  outside: Uint32Array,
  counts: string,
];

/** Frames between two breaths. */
const BATCH = 8;

/**
 * A prompt for each object: nobody has to click for models that follow an object from a click, a box or a mask. Points lie as
 * deep in the object as may be, and as far from it; docs/interchange.md says how SAM 2, SAM 3 and ComfyUI take them.
 *
 * ```js
 * const json = JSON.stringify(await prompts(result));
 * ```
 * @returns for `JSON.stringify`; prompts by their objects, ascending
 */
export async function prompts(masks: MaskSource, options: PromptsOptions = {}): Promise<PromptList> {
  checkMasks(masks);
  const { objects, decoder } = checkedOptions(options, ['objects', 'decoder']);
  const chosen = chosenLabels(objects);
  const { width, height, numFrames } = masks;
  const times = timesOf(masks);
  const module = await platform.loadDecoder(decoder);
  const call = <T>(work: () => T) => callDecoder(module, work, 'prompts cannot be made');
  const found = await call(() => new Prompts());
  for (let t = 0; t < numFrames; t += 1) {
    if (t % BATCH === BATCH - 1) await breath();
    const labels = labelsOf(masks, t);
    await call(() => found.add(firstOf(masks) + t, labels, width, chosen));
  }
  const entries: Entry[] = await call(() => found.finish());
  return {
    info: { description: 'Prompts for objects that TraceCut found', version: VERSION },
    width,
    height,
    prompts: entries.map(([object, frame, box, inside, outside, counts]) => ({
      obj_id: object,
      frame_idx: frame,
      box: Array.from(box),
      points: [...pairs(inside), ...pairs(outside)],
      labels: [...pairs(inside).map(() => 1), ...pairs(outside).map(() => 0)],
      mask: { size: [height, width], counts },
    })),
    ...(times && { times: [...times] }),
  };
}

function pairs(places: Uint32Array) {
  return Array.from({ length: places.length / 2 }, (_, k) => [Number(places[2 * k]), Number(places[2 * k + 1])]);
}
