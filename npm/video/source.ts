// Detects the kind of a source, and opens a reader of its frames.

import { TraceCutError, checkOptions, illegal, typeTag } from '../check/errors.js';
import { type Platform, loadPart, platform } from '../platform.js';
import { createDecoderLoader } from '../worker/remote.js';
import { openDemuxed } from './demux.js';
import { type FileKind, detectKind } from './file-kind.js';
import { type ShownFrame, reduceFrame, toShownFrame } from './pixels.js';
import { TAKE_NAMES, createEmptyError, splitTake, takeFrames } from './reader.js';
import type { ListedFrame } from './frame-list.js';
import type { Reader, Take, TakeOptions, VideoInfo } from './reader.js';

/**
 * Source of frames: a video file (MP4, MOV, WebM, MKV, MTS, …) or an animated GIF, PNG, WebP or AVIF as a `Blob`, its bytes
 * or its address, whatever its name; a video element that plays a file; a camera, a screen or a canvas, as a `MediaStream` or
 * its track; or single frames, as a list, a generator or a stream. Node takes single frames, and the path or
 * address of a file if ffmpeg is installed.
 *
 * Each `VideoFrame` of a list or stream is closed once it is read. A stream is read no faster than its frames are used,
 * and cancelled if reading ends before it does. The frames of a track queue, at most as many as a window has; those that
 * come while the queue is full are lost. The clip ends with the track, which is not stopped.
 */
export type VideoSource =
  | BrowserSource
  | string
  | URL
  | ReadableStream<ListedFrame>
  | AsyncIterable<ListedFrame>
  | Iterable<ListedFrame | Promise<ListedFrame>>;

/** The sources that browsers alone read. */
type BrowserSource = Blob | ArrayBuffer | Uint8Array | HTMLVideoElement | MediaStream | MediaStreamTrack;

const LEGAL_SOURCES =
  'a File or Blob, an address, a video element, a MediaStream or its track, or a list, generator or stream of frames';

/** `maxPixels` limits the size of single frames, `maxQueue` the number of frames of a track that wait to be used. */
export async function openReader(
  source: unknown,
  take: Take,
  loadDecoder: () => Promise<WebAssembly.Module>,
  { maxPixels, maxQueue }: { maxPixels?: number; maxQueue?: number } = {},
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
      if (platform.readVideo) return openWithPlatform(platform.readVideo, source as string | URL, take, maxPixels);
      return openAddress(source as string | URL);
    case 'HTMLVideoElement':
      return openVideoElement(source as HTMLVideoElement, take, maxQueue);
    case 'MediaStream':
      return openTrack(source as MediaStream, take, maxQueue);
    default:
      if (isTrack(source)) return openTrack(source, take, maxQueue);
      if (!isList(source)) throw illegal('data', 'source', source, LEGAL_SOURCES);
      return (await loadPart(import('./frame-list.js'))).openListed(source, {
        frameRate: take.frameRate,
        loadDecoder,
        maxPixels,
      });
  }
}

/** Opens a file that the platform reads frame by frame. */
async function openWithPlatform(
  readVideo: NonNullable<Platform['readVideo']>,
  address: string | URL,
  { signal, frameRate }: Take,
  maxPixels: number | undefined,
): Promise<Reader> {
  const options = { ...(signal && { signal }), ...(maxPixels !== undefined && { maxPixels }) };
  const frames = await readVideo(address, options);
  // They are decoded already.
  const loadDecoder = () => Promise.reject(new TraceCutError('state', 'a decoded frame needs no decoder'));
  const reader = (await loadPart(import('./frame-list.js'))).openListed(frames, { frameRate, loadDecoder });
  const info = async () => {
    throw new TraceCutError(
      'unsupported',
      'in Node a file has no info before its frames are read; videoFrames reads them',
    );
  };
  return { ...reader, info };
}

async function openTrack(source: MediaStream | MediaStreamTrack, take: Take, maxQueue: number | undefined) {
  const { openLive } = await loadPart(import('./live.js'));
  return openLive(source, { maxQueue, reduce: (raw) => reduceFrame(raw, take.size) });
}

/** Browsers have classes of tracks of their own, such as `CanvasCaptureMediaStreamTrack`. */
function isTrack(source: unknown): source is MediaStreamTrack {
  return /MediaStreamTrack(Generator)?$/.test(typeTag(source));
}

function isList(source: unknown): source is AsyncIterable<ListedFrame> {
  if (typeof source !== 'object' || source === null) return false;
  return Symbol.asyncIterator in source || Symbol.iterator in source || typeTag(source) === 'ReadableStream';
}

async function openFile(file: Blob): Promise<Reader> {
  checkBrowser();
  if (file.size === 0) throw new TraceCutError('no-video', 'the file is empty');
  const kind = await detectKind(file);
  if (kind?.kind === 'image') return (await loadPart(import('./images.js'))).openImage(file, kind.type);
  const before = isMatroska(kind) ? await (await loadPart(import('./webm-repair.js'))).repairCut(file) : null;
  return (await openDemuxed(before ?? file, before !== null)) ?? failUnreadable(kind);
}

const isMatroska = (kind: FileKind | null) => kind?.type === 'video/webm' || kind?.type === 'video/matroska';

function failUnreadable(kind: FileKind | null): never {
  const message = kind
    ? `files of the type ${kind.type} cannot be read here; convert it to MP4 (H.264) or WebM`
    : 'the file is not a video, nor an image, by its content';
  throw new TraceCutError('no-video', message);
}

async function openAddress(address: string | URL): Promise<Reader> {
  checkBrowser();
  const url = parseAddress(address);
  const file = await fetchWholeFile(url);
  return file ? openFile(file) : ((await openDemuxed(url)) ?? failUnreadable(null));
}

/** Fetches the file at an address; null if it can be read in parts. */
async function fetchWholeFile(url: URL) {
  if (!/^https?:$/.test(url.protocol)) return fetchFile(url);
  const response = await fetchResponse(url, { headers: { Range: 'bytes=0-' } });
  if (response.status !== 206) return response.blob();
  const reader = response.body?.getReader();
  const head = new Blob([(await reader?.read())?.value ?? new Uint8Array(0)]);
  reader?.cancel().catch(() => {});
  const kind = await detectKind(head);
  if (!isMatroska(kind)) return kind?.kind === 'image' ? fetchFile(url) : null;
  const { readDeclaredBytes } = await loadPart(import('./webm-repair.js'));
  const size = Number(response.headers.get('Content-Range')?.split('/')[1]);
  return (await readDeclaredBytes(head)) > size ? fetchFile(url) : null;
}

async function openVideoElement(video: HTMLVideoElement, take: Take, maxQueue: number | undefined): Promise<Reader> {
  if (typeTag(video.srcObject) === 'MediaStream') return openTrack(video.srcObject as MediaStream, take, maxQueue);
  const address = video.currentSrc || video.src;
  if (!address) throw new TraceCutError('no-video', 'the video element has nothing loaded; set its src first');
  return openAddress(address);
}

async function fetchFile(url: URL): Promise<Blob> {
  return (await fetchResponse(url)).blob();
}

async function fetchResponse(url: URL, request?: RequestInit) {
  const name = url.href.slice(0, 200);
  let response: Response;
  try {
    response = await fetch(url, request);
  } catch (cause) {
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${String(cause)}${getFetchHint(url)}`, { cause });
  }
  if (!response.ok)
    throw new TraceCutError('fetch', `${name} cannot be fetched: ${response.status} ${response.statusText}`);
  return response;
}

function getFetchHint(url: URL) {
  if (url.protocol === 'blob:')
    return '; a video element that plays a MediaSource has no file: pass what it is fed with';
  return url.origin === location.origin ? '' : '; another site has to allow it (Access-Control-Allow-Origin)';
}

function parseAddress(source: string | URL) {
  try {
    return new URL(source, typeof document === 'undefined' ? globalThis.location?.href : document.baseURI);
  } catch {
    throw illegal('data', 'source', source, 'the address of a video file');
  }
}

function checkBrowser() {
  if (typeof document !== 'undefined' || typeof VideoDecoder !== 'undefined') return;
  const files = platform.readVideo
    ? 'in Node pass the path of the file, which an installed ffmpeg decodes (framesOfVideo of tracecut/node has its options), or frames'
    : 'here pass frames';
  throw new TraceCutError(
    'unsupported',
    `the bytes of a video file are decoded by browsers only; ${files} one by one, such as the bytes of PNG or JPEG files`,
  );
}

/**
 * A decoded frame, its number among the selected ones, and its time and duration in seconds; `clip` if the source has
 * several.
 */
export type DecodedFrame = ShownFrame & {
  readonly index: number;
  readonly time: number;
  readonly duration: number;
  readonly clip?: string;
};

/** A frame of a source that only browsers read: it can be drawn on a canvas. */
export type DrawableFrame = DecodedFrame & { readonly frame: VideoFrame | ImageBitmap };

/**
 * Yields the pictures of a video for drawing: each once, in display order, upright, with square pixels, in the size of the
 * first, with its time and duration in seconds from the file; docs/frames.md has the rules. Nothing is read before the
 * first is requested, and leaving the loop closes the source. A file that is cut off or damaged yields the frames before;
 * then `onDamage` is called, or an error ends the loop (`truncated`).
 */
export function videoFrames(
  source: BrowserSource,
  options?: TakeOptions,
): AsyncGenerator<DrawableFrame, void, undefined>;
export function videoFrames(source: VideoSource, options?: TakeOptions): AsyncGenerator<DecodedFrame, void, undefined>;
export function videoFrames(source: VideoSource, options?: TakeOptions) {
  const { decoder, ...takeOptions } = checkOptions(options ?? {}, [...TAKE_NAMES, 'decoder']);
  const { take } = splitTake(takeOptions);
  return decodeFrames(source, take, createDecoderLoader(decoder));
}

async function* decodeFrames(
  source: unknown,
  take: Take,
  loadDecoder: () => Promise<WebAssembly.Module>,
): AsyncGenerator<DecodedFrame, void, undefined> {
  take.signal?.throwIfAborted();
  const reader = await openReader(source, take, loadDecoder);
  let count = 0;
  try {
    for await (const { raw, end: _, ...facts } of takeFrames(reader, take)) {
      const { close, ...shown } = await toShownFrame(raw, take.size, facts.time);
      try {
        yield { ...shown, ...facts };
      } finally {
        close();
      }
      count += 1;
    }
    if (count === 0) throw await createEmptyError(take, reader);
  } finally {
    reader.close();
  }
}

/**
 * Returns size, duration, frame rate and codec of a video: times come from the container, the size from the first picture.
 * `onDamage` is called for damage that is found without decoding everything; the facts then refer to the frames before it.
 * Without it that is an error (`truncated`).
 */
export async function videoInfo(source: VideoSource, options?: Pick<TakeOptions, 'onDamage'>): Promise<VideoInfo> {
  const { take } = splitTake(checkOptions(options ?? {}, ['onDamage']));
  const reader = await openReader(source, take, createDecoderLoader(undefined));
  try {
    const info = { ...(await reader.info()), times: await reader.times() };
    if (reader.damage && !take.onDamage) throw reader.damage;
    if (reader.damage) take.onDamage?.({ frames: info.numFrames ?? 0, total: null, error: reader.damage });
    return info;
  } finally {
    reader.close();
  }
}
