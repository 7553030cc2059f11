// Finds out what kind of source it was given, and opens a reader of its frames.

import { illegal, TraceCutError, typeTag } from '../check/errors.js';
import { part } from '../places.js';
import { decoderLoader } from '../worker/remote.js';
import { openDemuxed } from './demux.js';
import { fileKind } from './kind.js';
import { atSize, shownFrame } from './pixels.js';
import { asOptions, nothingTaken, splitTake, taken } from './reader.js';

/**
 * What frames are taken from: a video file (MP4, MOV, WebM, MKV, MTS, …) or an animated GIF, PNG, WebP or AVIF as a
 * `Blob`, its bytes or its address, whatever it is called; a video element that plays a file; a stream of a camera, a
 * screen or a canvas; or frames one by one, as a list, a generator or a stream. Node takes the last only.
 * @typedef {Blob | ArrayBuffer | Uint8Array | string | URL | HTMLVideoElement | MediaStream
 *   | ReadableStream<import('./listed.js').ListedFrame>
 *   | AsyncIterable<import('./listed.js').ListedFrame> | Iterable<import('./listed.js').ListedFrame | Promise<import('./listed.js').ListedFrame>>}
 *   VideoSource
 */

/** @typedef {import('./reader.js').Reader} Reader */
/** @typedef {import('./reader.js').Take} Take */

const LEGAL = 'a File or Blob, an address, a video element, a MediaStream, or a list, generator or stream of frames';

/**
 * @param {unknown} source
 * @param {Take} take
 * @param {() => Promise<WebAssembly.Module>} loadDecoder
 * @param {number} [maxPixels] of frames one by one
 * @returns {Promise<Reader>}
 */
export async function openReader(source, take, loadDecoder, maxPixels) {
  switch (typeTag(source)) {
    case 'Blob':
    case 'File':
      return openFile(/** @type {Blob} */ (source));
    case 'ArrayBuffer':
    case 'Uint8Array':
      return openFile(new Blob([/** @type {ArrayBuffer} */ (source)]));
    case 'String':
    case 'URL':
      return openAddress(/** @type {string | URL} */ (source));
    case 'HTMLVideoElement':
      return openVideoElement(/** @type {HTMLVideoElement} */ (source), take);
    case 'MediaStream':
      return openStream(/** @type {MediaStream} */ (source), take);
    default:
      if (!isList(source)) throw illegal('data', 'source', source, LEGAL);
      return (await part(import('./listed.js'))).openListed(source, {
        frameRate: take.frameRate,
        loadDecoder,
        maxPixels,
      });
  }
}

/**
 * @param {MediaStream} stream
 * @param {Take} take
 */
async function openStream(stream, take) {
  const { openLive } = await part(import('./live.js'));
  return openLive(stream, (raw) => atSize(raw, take.size));
}

/**
 * @param {unknown} source
 * @returns {source is AsyncIterable<import('./listed.js').ListedFrame>}
 */
function isList(source) {
  if (typeof source !== 'object' || source === null) return false;
  return Symbol.asyncIterator in source || Symbol.iterator in source || typeTag(source) === 'ReadableStream';
}

/**
 * @param {Blob} file
 * @returns {Promise<Reader>}
 */
async function openFile(file) {
  needsBrowser();
  if (file.size === 0) throw new TraceCutError('no-video', 'the file is empty');
  const found = await fileKind(file);
  if (found?.kind === 'image') return (await part(import('./images.js'))).openImage(file, found.type);
  const before = isMatroska(found) ? await (await part(import('./webm-cut.js'))).beforeCut(file) : null;
  return (await openDemuxed(before ?? file, before !== null)) ?? unreadable(found);
}

/** @param {import('./kind.js').FileKind | null} found */
const isMatroska = (found) => found?.type === 'video/webm' || found?.type === 'video/matroska';

/**
 * @param {import('./kind.js').FileKind | null} found
 * @returns {never}
 */
function unreadable(found) {
  const words = found
    ? `files of the type ${found.type} cannot be read here; convert it to MP4 (H.264) or WebM`
    : 'the file is not a video, nor an image, by its content';
  throw new TraceCutError('no-video', words);
}

/**
 * @param {string | URL} address
 * @returns {Promise<Reader>}
 */
async function openAddress(address) {
  needsBrowser();
  const url = addressOf(address);
  const file = await wholeFile(url);
  return file ? openFile(file) : ((await openDemuxed(url)) ?? unreadable(null));
}

/**
 * The file at an address, unless it can be read piece by piece: then null.
 * @param {URL} url
 */
async function wholeFile(url) {
  if (!/^https?:$/.test(url.protocol)) return fetched(url);
  const response = await answered(url, { headers: { Range: 'bytes=0-' } });
  if (response.status !== 206) return response.blob();
  const reader = response.body?.getReader();
  const head = new Blob([/** @type {Uint8Array<ArrayBuffer>} */ ((await reader?.read())?.value ?? new Uint8Array(0))]);
  reader?.cancel().catch(() => {});
  const found = await fileKind(head);
  if (!isMatroska(found)) return found?.kind === 'image' ? fetched(url) : null;
  const { declaredBytes } = await part(import('./webm-cut.js'));
  const size = Number(response.headers.get('Content-Range')?.split('/')[1]);
  return (await declaredBytes(head)) > size ? fetched(url) : null;
}

/**
 * @param {HTMLVideoElement} video
 * @param {Take} take
 * @returns {Promise<Reader>}
 */
async function openVideoElement(video, take) {
  if (typeTag(video.srcObject) === 'MediaStream') return openStream(/** @type {MediaStream} */ (video.srcObject), take);
  const address = video.currentSrc || video.src;
  if (!address) throw new TraceCutError('no-video', 'the video element has nothing loaded; set its src first');
  return openAddress(address);
}

/**
 * @param {URL} url
 * @returns {Promise<Blob>}
 */
async function fetched(url) {
  return (await answered(url)).blob();
}

/**
 * @param {URL} url
 * @param {RequestInit} [request]
 */
async function answered(url, request) {
  const name = url.href.slice(0, 200);
  /** @type {Response} */
  let response;
  try {
    response = await fetch(url, request);
  } catch (cause) {
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${String(cause)}${hintOf(url)}`, { cause });
  }
  if (!response.ok)
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${response.status} ${response.statusText}`);
  return response;
}

/** @param {URL} url */
function hintOf(url) {
  if (url.protocol === 'blob:')
    return '; a video element that plays a MediaSource has no file: pass what it is fed with';
  return url.origin === location.origin ? '' : '; another site has to allow it (Access-Control-Allow-Origin)';
}

/** @param {string | URL} source */
function addressOf(source) {
  try {
    return new URL(source, typeof document === 'undefined' ? globalThis.location?.href : document.baseURI);
  } catch {
    throw illegal('data', 'source', source, 'the address of a video file');
  }
}

function needsBrowser() {
  if (typeof document !== 'undefined' || typeof VideoDecoder !== 'undefined') return;
  throw new TraceCutError(
    'unsupported',
    'video files and addresses are decoded by browsers only; here pass the frames one by one, such as the bytes of PNG or JPEG files ' +
      '(for example `ffmpeg -i clip.mp4 %05d.png`, then a list of what readFile gives)',
  );
}

/**
 * A decoded frame, its number among those taken, and when and how long it is shown, in seconds; `clip` where the source has
 * several.
 * @typedef {import('./pixels.js').ShownFrame & {readonly index: number, readonly time: number, readonly duration: number,
 *   readonly clip?: string}} DecodedFrame
 */

/**
 * The pictures that a video holds, as a canvas draws them: each once, in the order in which they are shown, upright, in square pixels, of the
 * size of the first, with its time and duration in seconds as the file says them; docs/frames.md has the rules.
 * Nothing is read before the first is asked for, and leaving the loop closes the source. Of a file that is cut off or
 * damaged the frames before come; then `onDamage` is told, or an error ends the loop (`truncated`).
 * @param {VideoSource} source
 * @param {import('./reader.js').TakeOptions} [options]
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
export function videoFrames(source, options) {
  const { decoder, ...given } = asOptions(options);
  const { take, others } = splitTake(given);
  const stray = Object.keys(others)[0];
  if (stray)
    throw illegal(
      'param',
      stray,
      others[stray],
      'start, end, step, maxFrames, size, frameRate, decoder, signal or onDamage',
    );
  return decoded(
    source,
    take,
    decoderLoader(/** @type {import('../check/options.js').WasmSource | undefined} */ (decoder)),
  );
}

/**
 * @param {unknown} source
 * @param {import('./reader.js').Take} take
 * @param {() => Promise<WebAssembly.Module>} loadDecoder
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
async function* decoded(source, take, loadDecoder) {
  take.signal?.throwIfAborted();
  const reader = await openReader(source, take, loadDecoder);
  let count = 0;
  try {
    for await (const { raw, end: _, ...facts } of taken(reader, take)) {
      const { close, ...shown } = await shownFrame(raw, take.size, facts.time);
      try {
        yield { ...shown, ...facts };
      } finally {
        close();
      }
      count += 1;
    }
    if (count === 0) throw await nothingTaken(take, reader);
  } finally {
    reader.close();
  }
}

/**
 * Size, duration, frame rate and codec of a video: times are the container's, the size is that of the first picture.
 * `onDamage` is told of damage that shows without decoding all; facts are then of the frames before it. Without it that
 * is an error (`truncated`).
 * @param {VideoSource} source
 * @param {Pick<import('./reader.js').TakeOptions, 'onDamage'>} [options]
 * @returns {Promise<import('./reader.js').VideoInfo>}
 */
export async function videoInfo(source, options) {
  const { take, others } = splitTake(asOptions(options));
  const stray = Object.keys(others)[0];
  if (stray) throw illegal('param', stray, others[stray], 'onDamage');
  const reader = await openReader(source, take, decoderLoader(undefined));
  try {
    const info = { ...(await reader.info()), times: await reader.times() };
    if (reader.damage && !take.onDamage) throw reader.damage;
    if (reader.damage) take.onDamage?.({ frames: info.numFrames ?? 0, total: null, error: reader.damage });
    return info;
  } finally {
    reader.close();
  }
}
