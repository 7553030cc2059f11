// Finds out what kind of source it was given, and opens a reader of its frames.

import { TraceCutError, illegal, typeTag } from '../check/errors.js';
import { part } from '../places.js';
import { openDemuxed } from './demux.js';
import { atSize } from './pixels.js';

/**
 * What frames are taken from: a video file (MP4, MOV, WebM, MKV, …) or an animated GIF, PNG or WebP as a `Blob`, its
 * bytes or its address; a video element; a stream of a camera, a screen or a canvas; or frames one by one, as a list, a
 * generator or a stream. Node takes the last only.
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
      return openFile(/** @type {Blob} */ (source), take);
    case 'ArrayBuffer':
    case 'Uint8Array':
      return openFile(new Blob([/** @type {ArrayBuffer} */ (source)]), take);
    case 'String':
    case 'URL':
      return openAddress(/** @type {string | URL} */ (source), take);
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
 * @param {Take} take
 * @returns {Promise<Reader>}
 */
async function openFile(file, take) {
  needsBrowser();
  if (file.size === 0) throw new TraceCutError('no-video', 'the file is empty');
  const image = await imageType(file);
  if (image) return (await part(import('./images.js'))).openImage(file, image, take.onDamage !== undefined);
  const { beforeCut } = take.onDamage ? await part(import('./webm-cut.js')) : NOTHING_CUT;
  const before = await beforeCut(file);
  // A player of the browser's gets along with a cut as it is.
  const reader = await byBestMeans(before ?? file, take, () => {
    const url = URL.createObjectURL(file);
    return { url: new URL(url), release: () => URL.revokeObjectURL(url) };
  });
  const words = `the file is cut off at ${file.size} bytes, before its end`;
  return before ? { ...reader, damage: new TraceCutError('truncated', words) } : reader;
}

/** Files are looked at for a cut only where somebody wants to know. */
const NOTHING_CUT = { beforeCut: async (/** @type {Blob} */ _file) => null };

/**
 * The type of an image file by its first bytes; null for anything else.
 * @param {Blob} file
 * @returns {Promise<string | null>}
 */
async function imageType(file) {
  const head = new Uint8Array(await file.slice(0, 12).arrayBuffer());
  const text = String.fromCharCode(...head);
  if (text.startsWith('GIF8')) return 'image/gif';
  if (text.startsWith('\x89PNG')) return 'image/png';
  if (text.startsWith('\xff\xd8\xff')) return 'image/jpeg';
  return text.startsWith('RIFF') && text.slice(8) === 'WEBP' ? 'image/webp' : null;
}

/**
 * @param {string | URL} address
 * @param {Take} take
 * @returns {Promise<Reader>}
 */
async function openAddress(address, take) {
  needsBrowser();
  const url = addressOf(address);
  const file = await wholeFile(url);
  return file ? openFile(file, take) : byBestMeans(url, take, () => ({ url }));
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
  const head = await reader?.read();
  reader?.cancel().catch(() => {});
  // Animated images are taken apart whole.
  return head?.value && (await imageType(new Blob([head.value]))) ? fetched(url) : null;
}

/**
 * WebCodecs where it can, else a hidden video element.
 * @param {Blob | URL} source
 * @param {Take} take
 * @param {() => {url: URL, release?: () => void}} address of the source
 * @returns {Promise<Reader>}
 */
async function byBestMeans(source, { decoding }, address) {
  const demuxed = await openDemuxed(source);
  if (demuxed?.decodable && decoding !== 'seeking') return demuxed;
  const codec = demuxed?.codec ?? null;
  const times = demuxed && (await demuxed.times().catch(() => null));
  demuxed?.close();
  if (decoding === 'webcodecs') {
    const what = codec ?? 'the file, whose container is unknown,';
    throw new TraceCutError(
      'codec',
      `${what} cannot be decoded by WebCodecs here; decoding = 'auto' can fall back to the browser's player`,
    );
  }
  const { openSeeking } = await part(import('./seek.js'));
  return openSeeking(address().url, { ...address(), times, codec });
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
  const url = new URL(address);
  const demuxed = url.protocol === 'blob:' || url.origin === location.origin ? await demuxedOf(url) : null;
  if (demuxed?.decodable && take.decoding !== 'seeking') return demuxed;
  const times = demuxed && (await demuxed.times().catch(() => null));
  demuxed?.close();
  const { openElement } = await part(import('./seek.js'));
  return openElement(video, { times, codec: demuxed?.codec ?? null });
}

/**
 * What an element plays may be no file at all (a MediaSource): then it is sought in.
 * @param {URL} url
 */
async function demuxedOf(url) {
  try {
    return await openDemuxed(url.protocol === 'blob:' ? await fetched(url) : url);
  } catch {
    return null;
  }
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
    const hint = url.origin === location.origin ? '' : '; another site has to allow it (Access-Control-Allow-Origin)';
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${String(cause)}${hint}`, { cause });
  }
  if (!response.ok)
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${response.status} ${response.statusText}`);
  return response;
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
