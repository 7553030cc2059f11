// Masks for annotation tools and other models: COCO run lengths, and prompts.

import { checkOptions, checkWholeNumber, illegal, isPlainObject } from '../../check/errors.js';
import {
  MAX_LABEL,
  type MaskSource,
  type ObjectChoice,
  checkMasks,
  getFirstFrame,
  getTimes,
  readLabels,
  selectLabels,
} from '../../check/masks.js';
import { Prompts, cocoMask, cocoRuns } from '../../decoder.js';
import { VERSION } from '../../parameters.js';
import { platform } from '../../platform.js';
import { callDecoder } from '../../worker/instance.js';
import { yieldThread } from '../../worker/pause.js';
import { formatPngName } from './data.js';
import type { WasmSource } from '../../check/options.js';

/**
 * A COCO mask: `size` is height and width, `counts` its run lengths as a string or as plain numbers: columns from left to
 * right, each from top to bottom; first a run of 0, which may be empty, then of 1, and so on.
 */
export type CocoRle = { size: readonly number[]; counts: string | readonly number[] };

/** Largest side of a COCO mask. */
const MAX_COCO_SIDE = 65535;

/**
 * Decodes the mask of a COCO segmentation, the inverse of `cocoRle`.
 * @param options `decoder` is the file `decoder_bg.wasm`, if it is not beside the package
 * @returns 0 or 1 for each pixel, row by row
 */
export async function fromCocoRle(
  segmentation: CocoRle,
  options: { decoder?: WasmSource } = {},
): Promise<Uint8Array<ArrayBuffer>> {
  const { decoder } = checkOptions(options, ['decoder']);
  const { size, counts } = isPlainObject(segmentation) ? segmentation : { size: undefined, counts: undefined };
  if (!Array.isArray(size) || size.length !== 2 || !(typeof counts === 'string' || Array.isArray(counts))) {
    throw illegal('data', 'segmentation', segmentation, 'an object {size: [height, width], counts}');
  }
  const height = checkWholeNumber('data', 'size[0]', size[0], 1, MAX_COCO_SIDE);
  const width = checkWholeNumber('data', 'size[1]', size[1], 1, MAX_COCO_SIDE);
  const maxLength = width * height;
  // Characters beyond ASCII are illegal, and replaced by another illegal one. An empty string has no lengths.
  const [text, lengths] =
    typeof counts === 'string'
      ? [Array.from(counts, (letter) => Math.min(letter.charCodeAt(0), 127)), []]
      : [[], counts.map((length, i) => checkWholeNumber('data', `counts[${i}]`, length, 0, maxLength))];
  const mask = await callDecoder(
    await platform.loadDecoder(decoder),
    () => cocoMask(Uint8Array.from(text), Uint32Array.from(lengths), width, height),
    'the run lengths cannot be read',
  );
  return mask as Uint8Array<ArrayBuffer>;
}

/** Options of `cocoRle`. */
export interface CocoOptions {
  /** Objects to write; all but the background if not given. */
  objects?: ObjectChoice;
  /** Returns the file name of an image by its number in the clip; `00000.png` and so on if not given. */
  fileName?: (t: number) => string;
  /** Name of the clip; `video` if not given. */
  video?: string;
  /** Category of all objects, or of each; `object` if not given. */
  category?: string | ((label: number) => string);
  /** Frames per second, if the masks have no times. */
  frameRate?: number;
  /** The file `decoder_bg.wasm`, if it is not beside the package. */
  decoder?: WasmSource;
}

/** A frame; `timestamp` is its time in seconds, absent if unknown. */
export type CocoImage = {
  id: number;
  video_id: number;
  frame_index: number;
  width: number;
  height: number;
  file_name: string;
  timestamp?: number;
};

/**
 * An object in a frame. `track_id` is its label, the same in all frames, and repeated under `attributes` for importers
 * that read it there; `id` does not depend on the window that the frame is written from; `bbox` is left, top, width and
 * height in pixels.
 */
export type CocoAnnotation = {
  id: number;
  image_id: number;
  video_id: number;
  track_id: number;
  category_id: number;
  attributes: { track_id: number };
  area: number;
  bbox: [number, number, number, number];
  iscrowd: 0;
  segmentation: { size: [number, number]; counts: string };
};

/** A video; `frame_times` are the times of its images in seconds, absent if unknown. */
export type CocoVideo = { id: number; name: string; width: number; height: number; frame_times?: number[] };

/** A clip's masks in COCO format: its frames are images, its objects tracks. */
export type CocoMasks = {
  info: { description: string; version: string };
  videos: CocoVideo[];
  images: CocoImage[];
  tracks: { id: number; category_id: number; video_id: number }[];
  categories: { id: number; name: string }[];
  annotations: CocoAnnotation[];
};

const LEGAL = ['objects', 'fileName', 'video', 'category', 'frameRate', 'decoder'];

type CocoRunRow = [
  label: number,
  area: number,
  left: number,
  top: number,
  width: number,
  height: number,
  counts: string,
];

/** Number of the only video; numbers start from 1, because pycocotools reads 0 as none. */
const VIDEO_ID = 1;

/**
 * Converts masks to a COCO JSON for videos: an image for each frame, an annotation for each object in each frame, its
 * pixels as compressed run lengths that pycocotools reads. For a window of a clip only the settled frames are written,
 * with the clip's numbers: the images, annotations and `frame_times` of all windows add up to the clip's.
 *
 * ```js
 * const json = JSON.stringify(await cocoRle(masks));
 * ```
 * @returns for `JSON.stringify`
 */
export async function cocoRle(masks: MaskSource, options: CocoOptions = {}): Promise<CocoMasks> {
  checkMasks(masks);
  const {
    objects,
    fileName = formatPngName,
    video = 'video',
    category = 'object',
    frameRate,
    decoder,
  } = checkOptions(options, LEGAL);
  const selected = selectLabels(objects);
  const times = getTimes(masks, frameRate);
  const categories = new Categories(category);
  const module = await platform.loadDecoder(decoder);
  const { width, height } = masks;
  const { from, to } = getFrameRange(masks);
  const first = getFirstFrame(masks);
  const images = Array.from({ length: to - from }, (_, k) => {
    const t = from + k;
    const index = first + t;
    const image = { id: index + 1, video_id: VIDEO_ID, frame_index: index, width, height, file_name: fileName(index) };
    return times ? { ...image, timestamp: Number(times[t]) } : image;
  });
  const annotations: CocoAnnotation[] = [];
  const tracks = new Set<number>();
  for (let t = from; t < to; t += 1) {
    const labels = readLabels(masks, t);
    const runs: CocoRunRow[] = await callDecoder(
      module,
      () => cocoRuns(labels, width, selected),
      'run lengths cannot be made',
    );
    for (const [label, area, left, top, across, down, counts] of runs) {
      tracks.add(label);
      const ids = {
        // By frame and label, so that windows can be combined.
        id: (first + t) * (MAX_LABEL + 1) + label + 1,
        image_id: first + t + 1,
        video_id: VIDEO_ID,
        track_id: label,
        category_id: categories.idOf(label),
        attributes: { track_id: label },
      };
      annotations.push({
        ...ids,
        area,
        bbox: [left, top, across, down],
        iscrowd: 0,
        segmentation: { size: [height, width], counts },
      });
    }
  }
  return {
    info: { description: 'Masks of moving objects by TraceCut', version: VERSION },
    videos: [{ id: VIDEO_ID, name: video, width, height, ...(times && { frame_times: [...times.slice(from, to)] }) }],
    images,
    tracks: [...tracks]
      .sort((a, b) => a - b)
      .map((label) => ({ id: label, category_id: categories.idOf(label), video_id: VIDEO_ID })),
    categories: categories.list,
    annotations,
  };
}

/** Returns the range of frames to write: for a window the settled frames, so that each frame is in one window. */
function getFrameRange({ numFrames, settled }: MaskSource & { settled?: { from: number; to: number } }) {
  return settled ?? { from: 0, to: numFrames };
}

/** Categories by name, numbered from 1 in order of appearance. */
class Categories {
  name: (label: number) => string;
  list: { id: number; name: string }[];

  constructor(category: string | ((label: number) => string)) {
    if (typeof category !== 'string' && typeof category !== 'function')
      throw illegal('param', 'category', category, 'a name, or a function of a label');
    this.name = typeof category === 'function' ? category : () => category;
    this.list = typeof category === 'string' ? [{ id: 1, name: category }] : [];
  }

  idOf(label: number) {
    const name = this.name(label);
    const category = this.list.find((entry) => entry.name === name) ?? { id: this.list.length + 1, name };
    if (!this.list.includes(category)) this.list.push(category);
    return category.id;
  }
}

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
