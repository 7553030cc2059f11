// Reads streams of a camera, a screen or a canvas. They do not wait: frames are read as they arrive and queue until they
// are requested.

import { TraceCutError } from '../check/errors.js';
import { type RawFrame, toRawFrame } from '../worker/frames.js';
import { reduceFrame, stretchFrame } from './pixels.js';
import type { Reader, TimedFrame } from './reader.js';

/** Most queued frames, beyond which newer ones are dropped: the size of the largest window. */
const MAX_QUEUE = 400;

/** Interval at which a track is checked for its end. */
const WATCH_MS = 100;

type LiveFrame = { time: number; raw: RawFrame };

/** Offers a frame; resolves to true while more are needed. */
type OfferFrame = (timestamp: number, read: () => Promise<RawFrame>) => Promise<boolean>;

/** @param reduce applied to queued frames */
export function openLive(stream: MediaStream, reduce: (raw: RawFrame) => Promise<RawFrame>): Reader {
  const track = stream.getVideoTracks()[0];
  if (!track) throw new TraceCutError('no-video', 'the stream has no video track');
  const { width = 0, height = 0, frameRate = NaN } = track.getSettings();
  const closing = new AbortController();
  return {
    info: async () => ({ width, height, duration: Infinity, frameRate, codec: null, decodable: true }),
    times: async () => null,
    frames: (range) => readLiveFrames(track, range, reduce, closing.signal),
    close: () => closing.abort(),
  };
}

async function* readLiveFrames(
  track: MediaStreamTrack,
  { end }: { end: number },
  reduce: (raw: RawFrame) => Promise<RawFrame>,
  closed: AbortSignal,
): AsyncGenerator<TimedFrame, void, unknown> {
  const queue: LiveFrame[] = [];
  let wake = () => {};
  let isOver = false;
  let fault: unknown;
  let first = NaN;
  let last = -Infinity;
  /** Size of the first frame: a phone may be rotated meanwhile. */
  let size: { width: number; height: number } | undefined;
  const offer: OfferFrame = async (timestamp, read) => {
    if (Number.isNaN(first)) first = timestamp;
    const time = timestamp - first;
    if (isOver || time >= end) return false;
    if (time <= last) return true;
    last = time;
    if (queue.length < MAX_QUEUE) {
      const raw = await toFirstSize(await read());
      queue.push({ time, raw: await reduce(raw) });
    }
    wake();
    return true;
  };
  const toFirstSize = async (raw: RawFrame) => {
    if (raw.kind === 'file') return raw;
    size ??= { width: raw.width, height: raw.height };
    return raw.width === size.width && raw.height === size.height ? raw : stretchFrame(raw, size.width, size.height);
  };
  const stop = new AbortController();
  closed.addEventListener('abort', () => stop.abort(), { once: true });
  const feeding = hasProcessor()
    ? feedFromProcessor(track, offer, stop.signal)
    : feedFromElement(track, offer, stop.signal);
  feeding
    .catch((error) => (fault = error))
    .finally(() => {
      isOver = true;
      wake();
    });
  try {
    for (;;) {
      const next = queue.shift();
      if (next) yield { time: next.time, duration: 0, read: async () => next.raw, close() {} };
      else if (fault) throw fault;
      else if (isOver) return;
      else await new Promise((resolve: (value: void) => void) => (wake = resolve));
    }
  } finally {
    isOver = true;
    stop.abort();
  }
}

export type Processor = new (init: { track: MediaStreamTrack }) => { readable: ReadableStream<VideoFrame> };

const hasProcessor = () => 'MediaStreamTrackProcessor' in globalThis;

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
      try {
        if (!(await offer(frame.timestamp / 1e6, () => reduceFrame({ kind: 'image', image: frame }, undefined))))
          return;
      } finally {
        frame.close();
      }
    }
  } finally {
    cancel();
  }
}

async function feedFromElement(track: MediaStreamTrack, offer: OfferFrame, stop: AbortSignal) {
  if (typeof document === 'undefined')
    throw new TraceCutError('unsupported', 'a worker of this browser cannot read a stream; read it in the page');
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
          const more = await offer(mediaTime, () => toRawFrame(video, () => Promise.reject(new Error('no file'))));
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
