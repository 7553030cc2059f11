// Streams of a camera, a screen or a canvas. They do not wait: frames are read as they come and queue until they are
// taken.

import { TraceCutError } from '../check/errors.js';
import { toRawFrame } from '../worker/frames.js';
import { atSize, stretched } from './pixels.js';

/** Most frames that wait; newer ones are dropped then. As many as the largest window holds. */
const MAX_QUEUE = 400;

/** How often a track is asked whether it has ended. */
const WATCH_MS = 100;

/** @typedef {{time: number, raw: import('../worker/frames.js').RawFrame}} LiveFrame */
/** @typedef {(timestamp: number, read: () => Promise<import('../worker/frames.js').RawFrame>) => Promise<boolean>} OfferFrame True while more are wanted. */

/**
 * @param {MediaStream} stream
 * @param {(raw: import('../worker/frames.js').RawFrame) => Promise<import('../worker/frames.js').RawFrame>} reduce applied to what
 *   waits
 * @returns {import('./reader.js').Reader}
 */
export function openLive(stream, reduce) {
  const track = stream.getVideoTracks()[0];
  if (!track) throw new TraceCutError('no-video', 'the stream has no video track');
  const { width = 0, height = 0, frameRate = NaN } = track.getSettings();
  const closing = new AbortController();
  return {
    info: async () => ({ width, height, duration: Infinity, frameRate, codec: null, decodable: true }),
    times: async () => null,
    frames: (range) => liveFrames(track, range, reduce, closing.signal),
    close: () => closing.abort(),
  };
}

/**
 * @param {MediaStreamTrack} track
 * @param {{end: number}} range
 * @param {(raw: import('../worker/frames.js').RawFrame) => Promise<import('../worker/frames.js').RawFrame>} reduce
 * @param {AbortSignal} closed
 * @returns {AsyncGenerator<import('./reader.js').TimedFrame, void, unknown>}
 */
async function* liveFrames(track, { end }, reduce, closed) {
  /** @type {LiveFrame[]} */
  const queue = [];
  let wake = () => {};
  let over = false;
  /** @type {unknown} */
  let fault;
  let first = NaN;
  let last = -Infinity;
  /** @type {{width: number, height: number} | undefined} Of the first frame: a phone may be turned on the way. */
  let size;
  /** @type {OfferFrame} */
  const offer = async (timestamp, read) => {
    if (Number.isNaN(first)) first = timestamp;
    const time = timestamp - first;
    if (over || time >= end) return false;
    if (time <= last) return true;
    last = time;
    if (queue.length < MAX_QUEUE) {
      const raw = await sized(await read());
      queue.push({ time, raw: await reduce(raw) });
    }
    wake();
    return true;
  };
  const sized = async (/** @type {import('../worker/frames.js').RawFrame} */ raw) => {
    if (raw.kind === 'file') return raw;
    size ??= { width: raw.width, height: raw.height };
    return raw.width === size.width && raw.height === size.height ? raw : stretched(raw, size.width, size.height);
  };
  const stop = new AbortController();
  closed.addEventListener('abort', () => stop.abort(), { once: true });
  const feeding = hasProcessor() ? byProcessor(track, offer, stop.signal) : byElement(track, offer, stop.signal);
  feeding
    .catch((error) => (fault = error))
    .finally(() => {
      over = true;
      wake();
    });
  try {
    for (;;) {
      const next = queue.shift();
      if (next) yield { time: next.time, duration: 0, read: async () => next.raw, close() {} };
      else if (fault) throw fault;
      else if (over) return;
      else await new Promise((/** @type {(value: void) => void} */ resolve) => (wake = resolve));
    }
  } finally {
    over = true;
    stop.abort();
  }
}

/** @typedef {new (init: {track: MediaStreamTrack}) => {readable: ReadableStream<VideoFrame>}} Processor */

const hasProcessor = () => 'MediaStreamTrackProcessor' in globalThis;

/**
 * @param {MediaStreamTrack} track
 * @param {OfferFrame} offer
 * @param {AbortSignal} stop
 */
async function byProcessor(track, offer, stop) {
  const { MediaStreamTrackProcessor } = /** @type {{MediaStreamTrackProcessor: Processor}} */ (
    /** @type {unknown} */ (globalThis)
  );
  const reader = new MediaStreamTrackProcessor({ track }).readable.getReader();
  const cancel = () => void reader.cancel().catch(() => {});
  stop.addEventListener('abort', cancel, { once: true });
  try {
    if (stop.aborted) return;
    for (;;) {
      const { done, value: frame } = await reader.read();
      if (done) return;
      try {
        if (!(await offer(frame.timestamp / 1e6, () => atSize({ kind: 'image', image: frame }, undefined)))) return;
      } finally {
        frame.close();
      }
    }
  } finally {
    cancel();
  }
}

/**
 * @param {MediaStreamTrack} track
 * @param {OfferFrame} offer
 * @param {AbortSignal} stop
 */
async function byElement(track, offer, stop) {
  if (typeof document === 'undefined')
    throw new TraceCutError('unsupported', 'a worker of this browser cannot read a stream; read it in the page');
  const video = document.createElement('video');
  Object.assign(video, { muted: true, playsInline: true, srcObject: new MediaStream([track]) });
  /** @type {ReturnType<typeof setInterval> | undefined} */
  let watch;
  try {
    await new Promise((/** @type {(value: void) => void} */ resolve, reject) => {
      const end = () => resolve();
      stop.addEventListener('abort', end, { once: true });
      // A track that its owner stops says nothing; nor does the element.
      watch = setInterval(() => track.readyState === 'ended' && end(), WATCH_MS);
      const next = async (/** @type {number} */ _now, /** @type {{mediaTime: number}} */ { mediaTime }) => {
        // What an ended track shows last is black.
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
