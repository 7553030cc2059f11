// Finds out what kind of source it was given, and opens a reader of its frames.

import { illegal, TraceCutError, typeTag } from '../check/errors.js';
import { part } from '../places.js';
import { decoderLoader } from '../worker/remote.js';
import { openDemuxed } from './demux.js';
import { type FileKind, fileKind } from './kind.js';
import { type ShownFrame, atSize, shownFrame } from './pixels.js';
import { asOptions, nothingTaken, splitTake, taken } from './reader.js';
import type { WasmSource } from '../check/options.js';
import type { ListedFrame } from './listed.js';
import type { Reader, Take, TakeOptions, VideoInfo } from './reader.js';

/**
 * What frames are taken from: a video file (MP4, MOV, WebM, MKV, MTS, …) or an animated GIF, PNG, WebP or AVIF as a
 * `Blob`, its bytes or its address, whatever it is called; a video element that plays a file; a stream of a camera, a
 * screen or a canvas; or frames one by one, as a list, a generator or a stream. Node takes the last only.
 */
export type VideoSource =
  | Blob
  | ArrayBuffer
  | Uint8Array
  | string
  | URL
  | HTMLVideoElement
  | MediaStream
  | ReadableStream<ListedFrame>
  | AsyncIterable<ListedFrame>
  | Iterable<ListedFrame | Promise<ListedFrame>>;

const LEGAL = 'a File or Blob, an address, a video element, a MediaStream, or a list, generator or stream of frames';

/** @param maxPixels of frames one by one */
export async function openReader(
  source: unknown,
  take: Take,
  loadDecoder: () => Promise<WebAssembly.Module>,
  maxPixels?: number,
): Promise<Reader> {
  switch (typeTag(source)) {
    case 'Blob':
    case 'File':
      return openFile(source as Blob);
    case 'ArrayBuffer':
    case 'Uint8Array':
      return openFile(new Blob([source as ArrayBuffer]));
    case 'String':
    case 'URL':
      return openAddress(source as string | URL);
    case 'HTMLVideoElement':
      return openVideoElement(source as HTMLVideoElement, take);
    case 'MediaStream':
      return openStream(source as MediaStream, take);
    default:
      if (!isList(source)) throw illegal('data', 'source', source, LEGAL);
      return (await part(import('./listed.js'))).openListed(source, {
        frameRate: take.frameRate,
        loadDecoder,
        maxPixels,
      });
  }
}

async function openStream(stream: MediaStream, take: Take) {
  const { openLive } = await part(import('./live.js'));
  return openLive(stream, (raw) => atSize(raw, take.size));
}

function isList(source: unknown): source is AsyncIterable<ListedFrame> {
  if (typeof source !== 'object' || source === null) return false;
  return Symbol.asyncIterator in source || Symbol.iterator in source || typeTag(source) === 'ReadableStream';
}

async function openFile(file: Blob): Promise<Reader> {
  needsBrowser();
  if (file.size === 0) throw new TraceCutError('no-video', 'the file is empty');
  const found = await fileKind(file);
  if (found?.kind === 'image') return (await part(import('./images.js'))).openImage(file, found.type);
  const before = isMatroska(found) ? await (await part(import('./webm-cut.js'))).beforeCut(file) : null;
  return (await openDemuxed(before ?? file, before !== null)) ?? unreadable(found);
}

const isMatroska = (found: FileKind | null) => found?.type === 'video/webm' || found?.type === 'video/matroska';

function unreadable(found: FileKind | null): never {
  const words = found
    ? `files of the type ${found.type} cannot be read here; convert it to MP4 (H.264) or WebM`
    : 'the file is not a video, nor an image, by its content';
  throw new TraceCutError('no-video', words);
}

async function openAddress(address: string | URL): Promise<Reader> {
  needsBrowser();
  const url = addressOf(address);
  const file = await wholeFile(url);
  return file ? openFile(file) : ((await openDemuxed(url)) ?? unreadable(null));
}

/** The file at an address, unless it can be read piece by piece: then null. */
async function wholeFile(url: URL) {
  if (!/^https?:$/.test(url.protocol)) return fetched(url);
  const response = await answered(url, { headers: { Range: 'bytes=0-' } });
  if (response.status !== 206) return response.blob();
  const reader = response.body?.getReader();
  const head = new Blob([(await reader?.read())?.value ?? new Uint8Array(0)]);
  reader?.cancel().catch(() => {});
  const found = await fileKind(head);
  if (!isMatroska(found)) return found?.kind === 'image' ? fetched(url) : null;
  const { declaredBytes } = await part(import('./webm-cut.js'));
  const size = Number(response.headers.get('Content-Range')?.split('/')[1]);
  return (await declaredBytes(head)) > size ? fetched(url) : null;
}

async function openVideoElement(video: HTMLVideoElement, take: Take): Promise<Reader> {
  if (typeTag(video.srcObject) === 'MediaStream') return openStream(video.srcObject as MediaStream, take);
  const address = video.currentSrc || video.src;
  if (!address) throw new TraceCutError('no-video', 'the video element has nothing loaded; set its src first');
  return openAddress(address);
}

async function fetched(url: URL): Promise<Blob> {
  return (await answered(url)).blob();
}

async function answered(url: URL, request?: RequestInit) {
  const name = url.href.slice(0, 200);
  let response: Response;
  try {
    response = await fetch(url, request);
  } catch (cause) {
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${String(cause)}${hintOf(url)}`, { cause });
  }
  if (!response.ok)
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${response.status} ${response.statusText}`);
  return response;
}

function hintOf(url: URL) {
  if (url.protocol === 'blob:')
    return '; a video element that plays a MediaSource has no file: pass what it is fed with';
  return url.origin === location.origin ? '' : '; another site has to allow it (Access-Control-Allow-Origin)';
}

function addressOf(source: string | URL) {
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
 */
export type DecodedFrame = ShownFrame & {
  readonly index: number;
  readonly time: number;
  readonly duration: number;
  readonly clip?: string;
};

/**
 * The pictures that a video holds, as a canvas draws them: each once, in the order in which they are shown, upright, in square pixels, of the
 * size of the first, with its time and duration in seconds as the file says them; docs/frames.md has the rules.
 * Nothing is read before the first is asked for, and leaving the loop closes the source. Of a file that is cut off or
 * damaged the frames before come; then `onDamage` is told, or an error ends the loop (`truncated`).
 */
export function videoFrames(source: VideoSource, options?: TakeOptions): AsyncGenerator<DecodedFrame, void, undefined> {
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
  return decoded(source, take, decoderLoader(decoder as WasmSource | undefined));
}

async function* decoded(
  source: unknown,
  take: Take,
  loadDecoder: () => Promise<WebAssembly.Module>,
): AsyncGenerator<DecodedFrame, void, undefined> {
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
 */
export async function videoInfo(source: VideoSource, options?: Pick<TakeOptions, 'onDamage'>): Promise<VideoInfo> {
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
