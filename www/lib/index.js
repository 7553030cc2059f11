/**
 * TraceCut in browsers and bundlers: finds the moving objects in a video. The work runs in a module worker.
 *
 * ```js
 * const session = await createSession();
 * for (const frame of frames) await session.push(frame);
 * const result = await session.run({ onProgress: ({ stage, done, total }) => {} });
 * result.labels(0); result.trajectories; result.clusters.label; session.close();
 * ```
 * @module
 */

import { makeClip } from './clip.js';
import { enlarged } from './enlarge.js';
import { boundariesOf, discontinuitiesOf, flowOf, openImageEngine, superpixelsOf } from './image.js';
import { loadModule } from './load.js';
import { asideStarter, importing, known, part, wayOut } from './places.js';
import { loader } from './platform.js';
import { openSession } from './session.js';
import { framesOf, infoOf } from './video/frames.js';
import { preview } from './video/preview.js';
import { segment } from './video/segment.js';

export * from './common.js';

// Bundlers look for these very expressions, and for the worker's.
const packagedFile = () => new URL('./tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('./decoder_bg.wasm', import.meta.url);

/** @type {import('./platform.js').Platform} */
const platform = {
  loadModule: loader('wasm', loadModule, async () => loadModule(known('wasm', packagedFile), wayOut('wasm'))),
  loadDecoder: loader('decoder', loadModule, async () =>
    loadModule(known('decoder', packagedDecoder), wayOut('decoder')),
  ),
  get startWorker() {
    if (typeof Worker === 'undefined') return undefined;
    return startWorker;
  },
  get startAside() {
    if (typeof Worker === 'undefined') return undefined;
    return asideStarter(startAside);
  },
  cores: () => globalThis.navigator?.hardwareConcurrency,
};

function startWorker() {
  try {
    return new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
  } catch {
    return importing(known('worker', () => new URL('worker.js', packagedFile())));
  }
}

function startAside() {
  try {
    return new Worker(new URL('./aside/worker.js', import.meta.url), { type: 'module' });
  } catch {
    return importing(known('worker', () => new URL('aside/worker.js', packagedFile())));
  }
}

/**
 * Opens a session.
 * @param {import('./options.js').SessionOptions} [options]
 * @returns {Promise<import('./session.js').Session>}
 */
export function createSession(options) {
  return openSession(options, platform);
}

/**
 * Makes a clip of moving objects with known masks and known flow, on the calling thread.
 * @param {import('./clip.js').ClipOptions} [options]
 * @returns {Promise<import('./clip.js').Clip>}
 */
export function synthClip(options) {
  return makeClip(options, platform);
}

/**
 * The boundary probability of a single image, at its own size.
 * @param {import('./frames.js').FrameSource} image
 * @param {import('./image.js').ImageOptions} [options]
 * @returns {Promise<import('./image.js').BoundaryMap>}
 */
export function boundaries(image, options) {
  return boundariesOf(image, options, platform);
}

/**
 * The Gabriel superpixels of a single image, at its own size.
 * @param {import('./frames.js').FrameSource} image
 * @param {import('./image.js').SuperpixelOptions} [options]
 * @returns {Promise<import('./image.js').Superpixels>}
 */
export function superpixels(image, options) {
  return superpixelsOf(image, options, platform);
}

/**
 * Boundaries of a single image by the discontinuities of its pixel embedding, at its own size or reduced to
 * `still.maxSide`.
 * @param {import('./frames.js').FrameSource} image
 * @param {import('./image.js').DiscontinuityOptions} [options]
 * @returns {Promise<import('./image.js').ImageDiscontinuities>}
 */
export function imageDiscontinuities(image, options) {
  return discontinuitiesOf(image, options, platform);
}

/**
 * The optical flow from one image to another of the same size, at that size: where each pixel goes.
 * @param {import('./frames.js').FrameSource} from
 * @param {import('./frames.js').FrameSource} to
 * @param {import('./image.js').FlowOptions} [options]
 * @returns {Promise<import('./engine.js').FlowField>}
 */
export function flow(from, to, options) {
  return flowOf(from, to, options, platform);
}

/**
 * Follows points through a clip, and no more: flow and tracking of a session, in the time that these take. Memory grows
 * with the clip, as all of it is one window.
 *
 * ```js
 * const { count, startFrame, offset, x, y } = await trajectories(frames, { trajectory: { gridStep: 6 } });
 * ```
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./tracking.js').TrajectoryOptions} [options]
 * @returns {Promise<import('./tracking.js').TrackedClip>}
 */
export async function trajectories(source, options) {
  const { trackedOf } = await part(import('./tracking.js'));
  return trackedOf(source, options, platform);
}

/**
 * Opens an engine for boundaries, superpixels, discontinuities and flow of many single images: all that starting costs is
 * paid once.
 * @param {import('./image.js').ImageEngineOptions} [options]
 * @returns {Promise<import('./image.js').ImageEngine>}
 */
export function createImageEngine(options) {
  return openImageEngine(options, platform);
}

/**
 * Carries a painted edit to the frames before and after it, as parts of the same edit: its region goes with the optical
 * flow from frame to frame, within the shot, as long as the picture there looks like what it came from.
 *
 * ```js
 * const { first, last } = await carryEdit(editor, edit, { picture: (t) => frames[t] });
 * ```
 * @param {import('./edit/editor.js').MaskEditor} editor
 * @param {import('./edit/editor.js').Edit} edit as `paint` gave it, in force
 * @param {import('./edit/carry.js').CarryOptions} options
 * @returns {Promise<import('./edit/carry.js').Carried>}
 */
export async function carryEdit(editor, edit, options) {
  const { carryWith } = await part(import('./edit/carry.js'));
  return carryWith(editor, edit, options, () => openImageEngine({}, platform));
}

/**
 * Masks that flicker less: each pixel has the label that most of the frames around give to where the optical flow says
 * that it was and will be. What is in a single frame alone goes, what is missing in a single one comes. On eight
 * sequences of DAVIS 2016 that leaves J and F as they are (each .001 higher in the mean) and takes three tenths of the
 * changes along the flow away.
 *
 * ```js
 * const calm = await smoothMasks(result, { picture: (t) => frames[t] });
 * ```
 * @param {import('./export/mask-source.js').MaskSource} masks
 * @param {import('./edit/smooth.js').SmoothMasksOptions} options
 * @returns {Promise<import('./export/mask-source.js').MaskSource>} of the same size, times and shots
 */
export async function smoothMasks(masks, options) {
  const { smoothWith } = await part(import('./edit/smooth.js'));
  return smoothWith(masks, options, () => openImageEngine({}, platform));
}

/**
 * A mask at the size of its picture, which is larger than the mask or as large: borders come to where the picture parts
 * its colours, and are as soft as they are there. In browsers it runs in a worker; in Node on the calling thread.
 *
 * ```js
 * const { width, height, labels, alpha } = await enlargeMask({ labels, width: 480, height: 270 }, bitmap);
 * ```
 * @param {import('./enlarge.js').FrameMask} mask at the size that frames were processed at
 * @param {import('./frames.js').FrameSource} picture the frame as it was before it was reduced
 * @param {import('./enlarge.js').EnlargeOptions} [options]
 * @returns {Promise<import('./enlarge-here.js').EnlargedMask>}
 */
export function enlargeMask(mask, picture, options) {
  return enlarged(mask, picture, options, platform);
}

/**
 * Masks at the size of their frames, for exports at the size of the source: frames are read one by one, borders come to
 * where they have them (`enlargeMask`), masks are kept as runs of equal labels. All frames have one size.
 * @param {import('./export/mask-source.js').MaskSource} masks
 * @param {import('./export/video.js').EncodeFrames} frames one for each frame of the masks, in order
 * @param {import('./export/at-size.js').MasksAtSizeOptions} [options]
 * @returns {Promise<import('./export/mask-source.js').MaskSource>} with the times and shots of `masks`
 */
export async function masksAtSize(masks, frames, options) {
  const { allAtSize } = await part(import('./export/at-size.js'));
  return allAtSize(masks, frames, options, enlargeBy(options));
}

/**
 * The mask of frame `t` as a PNG file: in palette colours, or of one object in black and white.
 * @param {import('./export/mask-source.js').MaskSource} masks
 * @param {number} t
 * @param {import('./export/masks.js').MaskPngOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the bytes of the file
 */
export async function maskPng(masks, t, options) {
  const { pngOfMask } = await part(import('./export/masks.js'));
  return pngOfMask(masks, t, options, platform);
}

/**
 * All masks in one ZIP archive: PNG files, and `masks.json`, which says the frames' times and files, the labels and
 * their colours. The same masks give the same bytes.
 * @param {import('./export/mask-source.js').MaskSource} masks
 * @param {import('./export/masks.js').MasksZipOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the bytes of the archive
 */
export async function masksZip(masks, options) {
  const { zipOfMasks } = await part(import('./export/masks.js'));
  return zipOfMasks(masks, options, platform);
}

/**
 * The masks of several clips in one ZIP archive: a folder for each, with what `masksZip` puts into one, and
 * `report.json`, which says what became of each. The same masks give the same bytes.
 * @param {import('./export/clips-zip.js').ZippedClip[]} clips
 * @param {import('./export/clips-zip.js').ClipsZipOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the bytes of the archive
 */
export async function clipsZip(clips, options) {
  const { zipOfClips } = await part(import('./export/clips-zip.js'));
  return zipOfClips(clips, options, platform);
}

/**
 * Masks, and what was changed in them, as a file. The same masks and edits give the same bytes.
 * @param {import('./export/mask-source.js').MaskSource} masks without edits
 * @param {import('./export/project.js').ProjectOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} for `openProject`
 */
export async function saveProject(masks, options) {
  const { projectOf } = await part(import('./export/project.js'));
  return projectOf(masks, options, platform);
}

/**
 * Encodes masks and frames as a video with the masks' own times (the first frame is at 0). The video has the frames'
 * size, and masks that are smaller are enlarged by the frames (`enlargeMask`); MP4 wants even numbers, so an odd side
 * gets one more row or column, a copy of the last. Frames are neither kept nor closed.
 * @param {import('./export/mask-source.js').MaskSource} masks
 * @param {import('./export/video.js').EncodeFrames | null} frames null for the style `masks`, which needs none
 * @param {import('./export/video.js').EncodeVideoOptions} [options]
 * @returns {Promise<Blob>} the file
 */
export async function encodeVideo(masks, frames, options) {
  const { encode } = await part(import('./export/video.js'));
  return encode(masks, frames, options, enlargeBy(options));
}

/**
 * @param {{decoder?: import('./options.js').WasmSource} | undefined} options
 * @returns {import('./export/at-size.js').Enlarge}
 */
function enlargeBy(options) {
  const decoder = options?.decoder;
  return (mask, picture, { objects }) => enlarged(mask, picture, { objects, decoder }, platform);
}

/**
 * Objects cut out of their frames as PNG files with alpha, in an archive or as one animated PNG, or their opacity as grey
 * ones: written while the stream is read and no sooner, a frame or two in memory. The pictures have the frames' size;
 * masks that are smaller are enlarged by the frames (`enlargeMask`).
 *
 * ```js
 * const stream = await encodeImages(result, frames, { format: 'zip' });
 * const file = await new Response(stream).blob();
 * ```
 * @param {import('./export/mask-source.js').MaskSource} masks
 * @param {import('./export/video.js').EncodeFrames} frames one for each frame of the masks, in order
 * @param {import('./export/images.js').EncodeImagesOptions} [options]
 * @returns {Promise<ReadableStream<Uint8Array<ArrayBuffer>>>} the bytes of the file
 */
export async function encodeImages(masks, frames, options) {
  const { imagesOf } = await part(import('./export/images.js'));
  return imagesOf(masks, frames, options, enlargeBy(options), platform);
}

/**
 * Segments a video: a file, an address, a video element, a stream, or frames one by one (Node takes the last only).
 * Long clips are run window by window, in bounded memory; labels keep their meaning from window to window, and a cut
 * begins a new shot with new ones.
 *
 * ```js
 * const video = segmentVideo(file, { size: 480, end: 10 });
 * for await (const window of video) {
 *   for (const { time, labels } of window.frames()) console.log(time, labels);
 * }
 * ```
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./video/segment.js').VideoOptions} [options]
 * @returns {import('./video/segment.js').VideoSegmentation}
 */
export function segmentVideo(source, options) {
  return segment(source, options, platform);
}

/**
 * Coarse masks of a clip's first frames, long before its own are there: those of frames 0, 2, 4, … 14, made from pictures
 * of at most 320 pixels, on one thread. Where something moves is mostly right; small and slow things may be missing, and
 * labels are not those that the whole clip will have. Takes what `segmentVideo` takes, with `step: 2`, `maxFrames: 8`,
 * `threads: 1` and `clip.maxSide: 320` where the options say nothing else, and rejects as that does.
 *
 * ```js
 * const coarse = await previewMasks(file, { size: 480 });
 * drawLabels(context, coarse, 0);
 * ```
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./video/segment.js').VideoOptions} [options]
 * @returns {Promise<import('./video/result.js').VideoResult>} of the frames taken, at the size of the source or `size`
 */
export function previewMasks(source, options) {
  return preview(source, options, platform);
}

/**
 * The frames of a video, in order, each with its time in seconds; none is lost or doubled. Nothing is read before the
 * first is asked for, and leaving the loop closes the source.
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./video/options.js').TakeOptions} [options]
 * @returns {AsyncGenerator<import('./video/frames.js').DecodedFrame, void, undefined>}
 */
export function videoFrames(source, options) {
  return framesOf(source, options, platform);
}

/**
 * Size, duration, frame rate and codec of a video, read from its container where there is one. `onDamage` is told of
 * damage that shows without decoding; facts are then of the frames before it.
 * @param {import('./video/source.js').VideoSource} source
 * @param {Pick<import('./video/options.js').TakeOptions, 'decoding' | 'onDamage'>} [options]
 * @returns {Promise<import('./video/reader.js').VideoInfo>}
 */
export function videoInfo(source, options) {
  return infoOf(source, options, platform);
}

/**
 * A few frames of a video, evenly spread over it or over the part from `start` to `end`, in order: what a filmstrip
 * shows. A clip of fewer frames gives each once. A stream, and frames that a generator gives, have no strip: their
 * length is not known.
 *
 * ```js
 * for await (const { frame, time } of videoStrip(file, { count: 12, size: 96 })) console.log(time, frame);
 * ```
 * @param {import('./video/source.js').VideoSource} source
 * @param {import('./video/strip.js').StripOptions} [options]
 * @returns {AsyncGenerator<import('./video/frames.js').DecodedFrame, void, undefined>}
 */
export async function* videoStrip(source, options) {
  const { stripOf } = await part(import('./video/strip.js'));
  yield* stripOf(source, options, platform);
}

/**
 * The frames that lie as PNG or JPEG files in a folder, in the order of the numbers in their names (frame2 before
 * frame10), one read at a time. Hidden files and what is no picture are left out. In Node a folder is its path; a page
 * gives the files that a user chose.
 *
 * ```js
 * for await (const window of segmentVideo(readFrames('frames'), { frameRate: 30 })) console.log(window.objects);
 * ```
 * @param {string | URL | Iterable<File>} folder its path or `file:` address, or its files
 * @returns {AsyncGenerator<import('./video/folder.js').FrameFile, void, undefined>} for `segmentVideo`; errors of one
 *   that cannot be decoded say its name
 * @throws {TraceCutError} `no-frames` where the folder has no such file, `data` where a frame is in another format
 */
export async function* readFrames(folder) {
  const { framesOfFiles } = await part(import('./video/folder.js'));
  yield* framesOfFiles(folder);
}

/**
 * Segments several clips, one after the other, and gives what became of each: a clip that fails, or that its own signal
 * takes out, stops no other. The clips may be a generator: a queue that grows on the way.
 *
 * ```js
 * for await (const { name, result, error } of segmentEach(files.map((file) => ({ name: file.name, source: file }))))
 *   console.log(name, error ?? result.objects.length);
 * ```
 * @param {AsyncIterable<import('./video/each.js').QueuedClip> | Iterable<import('./video/each.js').QueuedClip>} clips
 * @param {import('./video/each.js').EachOptions} [options]
 * @returns {AsyncGenerator<import('./video/each.js').SegmentedClip, void, undefined>}
 */
export async function* segmentEach(clips, options) {
  const { eachOf } = await part(import('./video/each.js'));
  yield* eachOf(clips, options, segmentVideo);
}
