// Reads the video track of a camera, a screen or a canvas. Frames are read as they arrive and queue until they are
// requested; while the queue is full none is read, and the browser drops what nobody reads.

import { TraceCutError } from '../check/errors.js';
import { WINDOWS } from '../parameters.js';
import { type RawFrame, toRawFrame } from '../worker/frames.js';
import { reduceFrame, stretchFrame } from './pixels.js';
import type { Reader, TimedFrame } from './reader.js';

/** Interval at which a track is checked for its end. */
const WATCH_MS = 100;

/** A frame that a track shows now: either `read` or `close` is called, once. */
type OfferedFrame = { timestamp: number; read: () => Promise<RawFrame>; close: () => void };

/** Offers a frame; resolves once there is room for another, to true while more are needed. */
type OfferFrame = (frame: OfferedFrame) => Promise<boolean>;

interface LiveOptions {
  /** Most frames that are queued, at least 1; those of a window by default if not given. */
  maxQueue?: number | undefined;
  /** Applied to queued frames. */
  reduce: (raw: RawFrame) => Promise<RawFrame>;
}

export function openLive(source: MediaStream | MediaStreamTrack, options: LiveOptions): Reader {
  const track = 'getVideoTracks' in source ? source.getVideoTracks()[0] : source;
  if (track?.kind !== 'video') throw new TraceCutError('no-video', 'there is no video track');
  const { width = 0, height = 0, frameRate = NaN } = track.getSettings();
  const closing = new AbortController();
  return {
    info: async () => ({ width, height, duration: Infinity, frameRate, codec: null, decodable: true }),
    times: async () => null,
    frames: (range) => readLiveFrames(track, range, options, closing.signal),
    close: () => closing.abort(),
  };
}

async function* readLiveFrames(
  track: MediaStreamTrack,
  { end }: { end: number },
  { maxQueue = WINDOWS.frames, reduce }: LiveOptions,
  closed: AbortSignal,
): AsyncGenerator<TimedFrame, void, unknown> {
  const feed = chooseFeed();
  const queue: { time: number; raw: RawFrame }[] = [];
  const stop = new AbortController();
  let wake = () => {};
  let release = () => {};
  let isOver = false;
  let fault: unknown;
  let first = NaN;
  let last = -Infinity;
  /** Size of the first frame: a phone may be rotated meanwhile. */
  let size: { width: number; height: number } | undefined;
  const offer: OfferFrame = async ({ timestamp, read, close }) => {
    if (Number.isNaN(first)) first = timestamp;
    const time = timestamp - first;
    if (isOver || time >= end || time <= last) {
      close();
      return !isOver && time < end;
    }
    last = time;
    queue.push({ time, raw: await reduce(await toFirstSize(await read())) });
    wake();
    while (queue.length >= maxQueue && !isOver)
      await new Promise((resolve: (value: void) => void) => (release = resolve));
    return !isOver;
  };
  const toFirstSize = async (raw: RawFrame) => {
    if (raw.kind === 'file') return raw;
    size ??= { width: raw.width, height: raw.height };
    return raw.width === size.width && raw.height === size.height ? raw : stretchFrame(raw, size.width, size.height);
  };
  const finish = () => {
    isOver = true;
    wake();
    release();
    stop.abort();
  };
  if (closed.aborted || track.readyState === 'ended') return;
  closed.addEventListener('abort', finish, { once: true });
  feed(track, offer, stop.signal)
    .catch((error) => (fault = error))
    .finally(finish);
  try {
    for (;;) {
      const next = queue.shift();
      release();
      if (next) yield { time: next.time, duration: 0, read: async () => next.raw, close() {} };
      else if (fault) throw fault;
      else if (isOver) return;
      else await new Promise((resolve: (value: void) => void) => (wake = resolve));
    }
  } finally {
    finish();
  }
}

export type Processor = new (init: { track: MediaStreamTrack }) => { readable: ReadableStream<VideoFrame> };

/** Returns the way in which this browser reads a track, in a page or a worker. */
function chooseFeed() {
  if ('MediaStreamTrackProcessor' in globalThis) return feedFromProcessor;
  if ('requestVideoFrameCallback' in (globalThis.HTMLVideoElement?.prototype ?? {})) return feedFromElement;
  const missing = 'MediaStreamTrackProcessor, or in a page requestVideoFrameCallback of video elements';
  throw new TraceCutError('unsupported', `reading a track needs ${missing}`);
}

async function feedFromProcessor(track: MediaStreamTrack, offer: OfferFrame, stop: AbortSignal) {
  const { MediaStreamTrackProcessor } = globalThis as { MediaStreamTrackProcessor: Processor };
  const reader = new MediaStreamTrackProcessor({ track }).readable.getReader();
  const cancel = () => void reader.cancel().catch(() => {});
  stop.addEventListener('abort', cancel, { once: true });
  try {
    if (stop.aborted) return;
    for (;;) {
      const { done, value: frame } = await reader.read();
      if (done) return;
      // Reading closes it.
      const read = () => reduceFrame({ kind: 'image', image: frame }, undefined);
      if (!(await offer({ timestamp: frame.timestamp / 1e6, read, close: () => frame.close() }))) return;
    }
  } finally {
    cancel();
  }
}

async function feedFromElement(track: MediaStreamTrack, offer: OfferFrame, stop: AbortSignal) {
  const video = document.createElement('video');
  Object.assign(video, { muted: true, playsInline: true, srcObject: new MediaStream([track]) });
  let watch: ReturnType<typeof setInterval> | undefined;
  try {
    await new Promise((resolve: (value: void) => void, reject) => {
      const end = () => resolve();
      stop.addEventListener('abort', end, { once: true });
      // No event is fired when a track is stopped by its owner, neither by the track nor by the element.
      watch = setInterval(() => track.readyState === 'ended' && end(), WATCH_MS);
      const next = async (_now: number, { mediaTime }: { mediaTime: number }) => {
        // The last frame shown after a track has ended is black.
        if (track.readyState === 'ended') return;
        try {
          const read = () => toRawFrame(video, () => Promise.reject(new Error('no file')));
          const more = await offer({ timestamp: mediaTime, read, close() {} });
          if (more && !stop.aborted) video.requestVideoFrameCallback(next);
          else end();
        } catch (error) {
          reject(error);
        }
      };
      video.requestVideoFrameCallback(next);
      video.play().catch(reject);
      if (stop.aborted) end();
    });
  } finally {
    clearInterval(watch);
    video.pause();
    video.srcObject = null;
  }
}
