// Masks as COCO has them: run lengths, and the JSON for videos. Rust makes the runs, in the module that reads files too.

import { checkedOptions, illegal, isPlainObject, wholeNumber } from '../../check/errors.js';
import { MAX_LABEL, checkMasks, chosenLabels, firstOf, labelsOf, timesOf } from '../../check/masks.js';
import { cocoMask, cocoRuns } from '../../decoder.js';
import { VERSION } from '../../parameters.js';
import { platform } from '../../platform.js';
import { callDecoder } from '../../worker/decode.js';
import { pngName } from './data.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';
import type { WasmSource } from '../../check/options.js';

/**
 * A mask as COCO has it: `size` is height and width, `counts` its runs as a string, or as plain lengths: columns from left
 * to right, each from top to bottom; first a run of 0, which may be empty, then of 1, and so on.
 */
export type CocoRle = { size: readonly number[]; counts: string | readonly number[] };

const MAX_COCO_SIDE = 65535;

/**
 * The mask of a COCO segmentation, the inverse of what `cocoRle` writes.
 * @param options `decoder` says where `decoder_bg.wasm` is, when not beside the package
 * @returns 0 or 1 for each pixel, row by row
 */
export async function fromCocoRle(
  segmentation: CocoRle,
  options: { decoder?: WasmSource } = {},
): Promise<Uint8Array<ArrayBuffer>> {
  const { decoder } = checkedOptions(options, ['decoder']);
  const { size, counts } = isPlainObject(segmentation) ? segmentation : { size: undefined, counts: undefined };
  if (!Array.isArray(size) || size.length !== 2 || !(typeof counts === 'string' || Array.isArray(counts))) {
    throw illegal('data', 'segmentation', segmentation, 'an object {size: [height, width], counts}');
  }
  const height = wholeNumber('data', 'size[0]', size[0], 1, MAX_COCO_SIDE);
  const width = wholeNumber('data', 'size[1]', size[1], 1, MAX_COCO_SIDE);
  const most = width * height;
  // No letter of a string is beyond ASCII, and a string that is empty covers no more than no lengths.
  const [text, lengths] =
    typeof counts === 'string'
      ? [Array.from(counts, (letter) => Math.min(letter.charCodeAt(0), 127)), []]
      : [[], counts.map((length, i) => wholeNumber('data', `counts[${i}]`, length, 0, most))];
  const mask = await callDecoder(
    await platform.loadDecoder(decoder),
    () => cocoMask(Uint8Array.from(text), Uint32Array.from(lengths), width, height),
    'the run lengths cannot be read',
  );
  return mask as Uint8Array<ArrayBuffer>;
}

export interface CocoOptions {
  /** All but the background if not given. */
  objects?: ObjectChoice;
  /** Of each frame's image, by its number in the clip; `00000.png` and so on if not given. */
  fileName?: (t: number) => string;
  /** The clip's name; `video` if not given. */
  video?: string;
  /** Of all objects, or of each; `object` if not given. */
  category?: string | ((label: number) => string);
  /** Frames per second, where the masks have no times. */
  frameRate?: number;
  /** Where `decoder_bg.wasm` is, when not beside the package. */
  decoder?: WasmSource;
}

/** A frame; `timestamp` is its time in seconds and missing where none is known. */
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
 * An object in a frame. `track_id` is its label, the same in all frames, and under `attributes` for importers that look
 * there; `id` is the same whatever window the frame is written from; `bbox` is left, top, width and height in pixels.
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

/** A video; `frame_times` are the times of its images in seconds, and missing where none are known. */
export type CocoVideo = { id: number; name: string; width: number; height: number; frame_times?: number[] };

/** A clip's masks as COCO has them: images are its frames, tracks its objects. */
export type CocoMasks = {
  info: { description: string; version: string };
  videos: CocoVideo[];
  images: CocoImage[];
  tracks: { id: number; category_id: number; video_id: number }[];
  categories: { id: number; name: string }[];
  annotations: CocoAnnotation[];
};

const LEGAL = ['objects', 'fileName', 'video', 'category', 'frameRate', 'decoder'];

export type Runs = [
  label: number,
  area: number,
  left: number,
  top: number,
  width: number,
  height: number,
  counts: string,
];

/** There is one video; numbers start from 1, because pycocotools takes 0 for none. */
const VIDEO = 1;

/**
 * The masks as a COCO JSON for videos: an image for each frame, an annotation for each object in each frame where it
 * is, its pixels as compressed run lengths that pycocotools reads. Of a window of a clip the settled frames are written,
 * with the clip's numbers: the images, annotations and `frame_times` of all windows, one after the other, are those of the clip.
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
    fileName = pngName,
    video = 'video',
    category = 'object',
    frameRate,
    decoder,
  } = checkedOptions(options, LEGAL);
  const chosen = chosenLabels(objects);
  const times = timesOf(masks, frameRate);
  const categories = new Categories(category);
  const module = await platform.loadDecoder(decoder);
  const { width, height } = masks;
  const { from, to } = framesOf(masks);
  const first = firstOf(masks);
  const images = Array.from({ length: to - from }, (_, k) => {
    const t = from + k;
    const index = first + t;
    const image = { id: index + 1, video_id: VIDEO, frame_index: index, width, height, file_name: fileName(index) };
    return times ? { ...image, timestamp: Number(times[t]) } : image;
  });
  const annotations: CocoAnnotation[] = [];
  const tracks = new Set<number>();
  for (let t = from; t < to; t += 1) {
    const labels = labelsOf(masks, t);
    const runs: Runs[] = await callDecoder(module, () => cocoRuns(labels, width, chosen), 'run lengths cannot be made');
    for (const [label, area, left, top, across, down, counts] of runs) {
      tracks.add(label);
      const ids = {
        // By frame and label, so that windows can be put together.
        id: (first + t) * (MAX_LABEL + 1) + label + 1,
        image_id: first + t + 1,
        video_id: VIDEO,
        track_id: label,
        category_id: categories.of(label),
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
    videos: [{ id: VIDEO, name: video, width, height, ...(times && { frame_times: [...times.slice(from, to)] }) }],
    images,
    tracks: [...tracks]
      .sort((a, b) => a - b)
      .map((label) => ({ id: label, category_id: categories.of(label), video_id: VIDEO })),
    categories: categories.list,
    annotations,
  };
}

/** The frames that are written: of a window those that it settles, so that over all windows each is there once. */
function framesOf({ numFrames, settled }: MaskSource & { settled?: { from: number; to: number } }) {
  return settled ?? { from: 0, to: numFrames };
}

/** Categories by name, numbered from 1 as they come up. */
class Categories {
  name: (label: number) => string;
  list: { id: number; name: string }[];

  constructor(category: string | ((label: number) => string)) {
    if (typeof category !== 'string' && typeof category !== 'function')
      throw illegal('param', 'category', category, 'a name, or a function of a label');
    this.name = typeof category === 'function' ? category : () => category;
    this.list = typeof category === 'string' ? [{ id: 1, name: category }] : [];
  }

  of(label: number) {
    const name = this.name(label);
    const known = this.list.find((entry) => entry.name === name) ?? { id: this.list.length + 1, name };
    if (!this.list.includes(known)) this.list.push(known);
    return known.id;
  }
}
