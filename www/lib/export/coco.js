// Masks as a COCO JSON for videos.

import { checkedOptions, illegal } from '../errors.js';
import { VERSION } from '../parameters.js';
import { MAX_LABEL, checkMasks, chosenLabels, firstOf, labelsOf, timesOf } from './mask-source.js';
import { runsOf, toCounts } from './rle.js';

/**
 * @typedef {object} CocoOptions
 * @property {import('./mask-source.js').ObjectChoice} [objects] all but the background if not given
 * @property {(t: number) => string} [fileName] of each frame's image, by its number in the clip; `00000.png` and so on
 *   if not given
 * @property {string} [video] the clip's name; `video` if not given
 * @property {string | ((label: number) => string)} [category] of all objects, or of each; `object` if not given
 * @property {number} [frameRate] frames per second, where the masks have no times
 */

/**
 * A frame; `timestamp` is its time in seconds and missing where none is known. @typedef {{id: number, video_id: number,
 * frame_index: number, width: number, height: number, file_name: string, timestamp?: number}} CocoImage
 */

/**
 * An object in a frame. `track_id` is its label, the same in all frames, and under `attributes` for importers that
 * look there; `id` is the same whatever window the frame is written from; `bbox` is left, top, width and height in
 * pixels.
 * @typedef {{id: number, image_id: number, video_id: number, track_id: number, category_id: number, attributes:
 *   {track_id: number}, area: number, bbox: [number, number, number, number], iscrowd: 0, segmentation: {size:
 *   [number, number], counts: string}}}
 *   CocoAnnotation
 */

/**
 * A clip's masks as COCO has them: images are its frames, tracks its objects.
 * @typedef {{info: {description: string, version: string}, videos: {id: number, name: string, width: number, height:
 *   number}[], images: CocoImage[], tracks: {id: number, category_id: number, video_id: number}[], categories: {id:
 *   number, name: string}[], annotations: CocoAnnotation[]}} CocoMasks
 */

const LEGAL = ['objects', 'fileName', 'video', 'category', 'frameRate'];

/** There is one video; numbers start from 1, because pycocotools takes 0 for none. */
const VIDEO = 1;

/**
 * The masks as a COCO JSON for videos: an image for each frame, an annotation for each object in each frame where it
 * is, its pixels as compressed run lengths that pycocotools reads. Of a window of a clip the settled frames are
 * written,
 * with the clip's numbers: the images and annotations of all windows, one after the other, are those of the clip.
 * @param {import('./mask-source.js').MaskSource} masks
 * @param {CocoOptions} [options]
 * @returns {CocoMasks} for `JSON.stringify`
 */
export function cocoRle(masks, options = {}) {
  checkMasks(masks);
  const {
    objects,
    fileName = pngName,
    video = 'video',
    category = 'object',
    frameRate,
  } = checkedOptions(options, LEGAL);
  const chosen = chosenLabels(objects);
  const times = timesOf(masks, frameRate);
  const categories = new Categories(category);
  const { width, height } = masks;
  const { from, to } = framesOf(masks);
  const first = firstOf(masks);
  const images = Array.from({ length: to - from }, (_, k) => {
    const t = from + k;
    const index = first + t;
    const image = { id: index + 1, video_id: VIDEO, frame_index: index, width, height, file_name: fileName(index) };
    return times ? { ...image, timestamp: Number(times[t]) } : image;
  });
  /** @type {CocoAnnotation[]} */
  const annotations = [];
  /** @type {Set<number>} */
  const tracks = new Set();
  for (let t = from; t < to; t += 1) {
    for (const { label, counts, area, bbox } of runsOf(labelsOf(masks, t), width, height)) {
      if (!chosen[label]) continue;
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
        bbox,
        iscrowd: 0,
        segmentation: { size: [height, width], counts: toCounts(counts) },
      });
    }
  }
  return {
    info: { description: 'Masks of moving objects by TraceCut', version: VERSION },
    videos: [{ id: VIDEO, name: video, width, height }],
    images,
    tracks: [...tracks]
      .sort((a, b) => a - b)
      .map((label) => ({ id: label, category_id: categories.of(label), video_id: VIDEO })),
    categories: categories.list,
    annotations,
  };
}

/**
 * The frames that are written: of a window those that it settles, so that over all windows each is there once.
 * @param {import('./mask-source.js').MaskSource & {settled?: {from: number, to: number}}} masks
 */
function framesOf({ numFrames, settled }) {
  return settled ?? { from: 0, to: numFrames };
}

/** Categories by name, numbered from 1 as they come up. */
class Categories {
  /** @param {string | ((label: number) => string)} category */
  constructor(category) {
    if (typeof category !== 'string' && typeof category !== 'function')
      throw illegal('param', 'category', category, 'a name, or a function of a label');
    this.name = typeof category === 'function' ? category : () => category;
    /** @type {{id: number, name: string}[]} */
    this.list = typeof category === 'string' ? [{ id: 1, name: category }] : [];
  }

  /** @param {number} label */
  of(label) {
    const name = this.name(label);
    const known = this.list.find((entry) => entry.name === name) ?? { id: this.list.length + 1, name };
    if (!this.list.includes(known)) this.list.push(known);
    return known.id;
  }
}

/**
 * The name of frame `t`'s file in an archive of masks.
 * @param {number} t
 */
export function pngName(t) {
  return `${String(t).padStart(5, '0')}.png`;
}
