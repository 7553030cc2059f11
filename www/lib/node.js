/**
 * TraceCut in Node: the same interface as in browsers, and readers of streams and files; the work runs in-process, in
 * slices, and on threads beside it, or with `worker: true` off the calling thread altogether.
 * @module
 */

import { existsSync } from 'node:fs';
import { readFile, readdir } from 'node:fs/promises';
import { availableParallelism } from 'node:os';
import { basename, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { Worker } from 'node:worker_threads';
import { makeClip } from './clip.js';
import { enlarged } from './enlarge.js';
import { TraceCutError } from './errors.js';
import { boundariesOf, discontinuitiesOf, flowOf, openImageEngine, superpixelsOf } from './image.js';
import { loadModule } from './load.js';
import { startThread } from './node-thread.js';
import { known, part } from './places.js';
import { loader } from './platform.js';
import { openSession } from './session.js';
import { framesOf, infoOf } from './video/frames.js';
import { preview } from './video/preview.js';
import { segment } from './video/segment.js';

export * from './common.js';
export { framesOfRaw, framesOfVideo, framesOfY4m } from './node-frames.js';

/** @typedef {import('./node-frames.js').ByteSource} ByteSource */
/** @typedef {import('./node-frames.js').FfmpegOptions} FfmpegOptions */
/** @typedef {import('./node-frames.js').RawOptions} RawOptions */

// Bundlers that carry files along look for these very expressions.
const packagedFile = () => new URL('./tracecut_bg.wasm', import.meta.url);
const packagedDecoder = () => new URL('./decoder_bg.wasm', import.meta.url);

/** @type {import('./platform.js').Platform} */
const platform = {
  loadModule: loader('wasm', load, () => readPackaged('wasm', 'tracecut_bg.wasm', packagedFile)),
  loadDecoder: loader('decoder', load, () => readPackaged('decoder', 'decoder_bg.wasm', packagedDecoder)),
  startWorker: startThread,
  inProcess: true,
  startHelper,
  cores: availableParallelism,
};

/** @type {NonNullable<import('./platform.js').Platform['startHelper']>} */
function startHelper(data) {
  const port = /** @type {import('node:worker_threads').MessagePort} */ (/** @type {unknown} */ (data.port));
  const worker = new Worker(new URL('./node-worker.js', import.meta.url), {
    workerData: data,
    transferList: [port],
    // Those of the process may be for its script alone, as `--input-type` is.
    execArgv: [],
  });
  // A session that nobody closed keeps no process alive.
  worker.unref();
  return {
    watch(onLost) {
      worker.on('error', onLost);
      worker.on('exit', onLost);
    },
    end: () => void worker.terminate(),
  };
}

/** @param {import('./options.js').WasmSource} source */
function load(source) {
  if (source instanceof URL && source.protocol === 'file:') return readModule(source);
  return typeof source === 'string' && !/^[a-z][a-z\d+.-]+:/i.test(source) ? readModule(source) : loadModule(source);
}

/**
 * A file beside this module. Where a bundler gives an address of its own in its place, as webpack does, it is looked for
 * where this module was when it was bundled.
 * @param {'wasm' | 'decoder'} name
 * @param {string} file
 * @param {() => URL} make
 */
async function readPackaged(name, file, make) {
  const url = known(name, make, wayOut(name, file));
  const here = import.meta.url;
  const candidates = url.href.startsWith('file:') ? [new URL(url.href)] : [];
  candidates.push(new URL(file, here));
  const found = candidates.find((candidate) => existsSync(candidate)) ?? candidates[0];
  return readModule(/** @type {URL} */ (found), wayOut(name, file));
}

/**
 * The way out where a bundler has left a file behind.
 * @param {string} name
 * @param {string} file
 */
function wayOut(name, file) {
  return `If your bundler leaves it out, keep the package out of the bundle (external: ['tracecut'], serverExternalPackages: ['tracecut']), or copy tracecut/dist/${file} and say where: configure({ ${name}: 'path/of/${file}' })`;
}

/**
 * @param {URL | string} place
 * @param {string} [hint]
 */
async function readModule(place, hint) {
  try {
    return await loadModule(await readFile(place));
  } catch (cause) {
    if (cause instanceof TraceCutError) throw cause;
    const words = `${place instanceof URL ? place.href : place} could not be read: ${String(cause)}`;
    throw new TraceCutError('wasm-load', hint ? `${words}. ${hint}` : words, { cause });
  }
}

// Types and descriptions are those of the browsers' entry, which is what `types` in package.json names; one constant
// for each function, so that bundlers can drop what is not used.
/** @typedef {typeof import('./index.js')} Browser */

/** @type {Browser['createSession']} */
export const createSession = (options) => openSession(options, platform);
/** @type {Browser['synthClip']} */
export const synthClip = (options) => makeClip(options, platform);
/** @type {Browser['boundaries']} */
export const boundaries = (image, options) => boundariesOf(image, options, platform);
/** @type {Browser['superpixels']} */
export const superpixels = (image, options) => superpixelsOf(image, options, platform);
/** @type {Browser['imageDiscontinuities']} */
export const imageDiscontinuities = (image, options) => discontinuitiesOf(image, options, platform);
/** @type {Browser['flow']} */
export const flow = (from, to, options) => flowOf(from, to, options, platform);
/** @type {Browser['trajectories']} */
export const trajectories = async (source, options) => {
  const { trackedOf } = await part(import('./tracking.js'));
  return trackedOf(source, options, platform);
};
/** @type {Browser['createImageEngine']} */
export const createImageEngine = (options) => openImageEngine(options, platform);
/** @type {Browser['carryEdit']} */
export const carryEdit = async (editor, edit, options) => {
  const { carryWith } = await part(import('./edit/carry.js'));
  return carryWith(editor, edit, options, () => openImageEngine({}, platform));
};
/** @type {Browser['smoothMasks']} */
export const smoothMasks = async (masks, options) => {
  const { smoothWith } = await part(import('./edit/smooth.js'));
  return smoothWith(masks, options, () => openImageEngine({}, platform));
};
/** @type {Browser['enlargeMask']} */
export const enlargeMask = (mask, picture, options) => enlarged(mask, picture, options, platform);
/** @type {Browser['masksAtSize']} */
export const masksAtSize = async (masks, frames, options) => {
  const { allAtSize } = await part(import('./export/at-size.js'));
  return allAtSize(masks, frames, options, enlargeBy(options));
};
/** @type {Browser['maskPng']} */
export const maskPng = async (masks, t, options) => {
  const { pngOfMask } = await part(import('./export/masks.js'));
  return pngOfMask(masks, t, options, platform);
};
/** @type {Browser['masksZip']} */
export const masksZip = async (masks, options) => {
  const { zipOfMasks } = await part(import('./export/masks.js'));
  return zipOfMasks(masks, options, platform);
};
/** @type {Browser['clipsZip']} */
export const clipsZip = async (clips, options) => {
  const { zipOfClips } = await part(import('./export/clips-zip.js'));
  return zipOfClips(clips, options, platform);
};
/** @type {Browser['saveProject']} */
export const saveProject = async (masks, options) => {
  const { projectOf } = await part(import('./export/project.js'));
  return projectOf(masks, options, platform);
};
/** @type {Browser['encodeVideo']} */
export const encodeVideo = async (masks, frames, options) => {
  const { encode } = await part(import('./export/video.js'));
  return encode(masks, frames, options, enlargeBy(options));
};
/** @type {Browser['encodeImages']} */
export const encodeImages = async (masks, frames, options) => {
  const { imagesOf } = await part(import('./export/images.js'));
  return imagesOf(masks, frames, options, enlargeBy(options), platform);
};
/** @type {Browser['segmentVideo']} */
export const segmentVideo = (source, options) => segment(source, options, platform);
/** @type {Browser['previewMasks']} */
export const previewMasks = (source, options) => preview(source, options, platform);
/** @type {Browser['videoFrames']} */
export const videoFrames = (source, options) => framesOf(source, options, platform);
/** @type {Browser['videoInfo']} */
export const videoInfo = (source, options) => infoOf(source, options, platform);

/**
 * @param {{decoder?: import('./options.js').WasmSource} | undefined} options
 * @returns {import('./export/at-size.js').Enlarge}
 */
function enlargeBy(options) {
  const decoder = options?.decoder;
  return (mask, picture, { objects }) => enlarged(mask, picture, { objects, decoder }, platform);
}

/** @type {Browser['videoStrip']} */
export const videoStrip = async function* (source, options) {
  const { stripOf } = await part(import('./video/strip.js'));
  yield* stripOf(source, options, platform);
};
/** @type {Browser['readFrames']} */
export const readFrames = async function* (folder) {
  const { frameNames, framesOfFiles } = await part(import('./video/folder.js'));
  if (typeof folder !== 'string' && !(folder instanceof URL)) {
    yield* framesOfFiles(folder);
    return;
  }
  const path = typeof folder === 'string' ? folder : fileURLToPath(folder);
  for (const name of frameNames(await filesIn(path), `the folder ${basename(path)}`))
    yield { frame: new Uint8Array(await readFile(join(path, name))), name };
};

/** @param {string} path */
async function filesIn(path) {
  try {
    const entries = await readdir(path, { withFileTypes: true });
    return entries.filter((entry) => !entry.isDirectory()).map(({ name }) => name);
  } catch (cause) {
    throw new TraceCutError('no-frames', `the folder ${path} cannot be read: ${String(cause)}`, { cause });
  }
}
/** @type {Browser['segmentEach']} */
export const segmentEach = async function* (clips, options) {
  const { eachOf } = await part(import('./video/each.js'));
  yield* eachOf(clips, options, segmentVideo);
};
