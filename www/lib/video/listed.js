// Frames that the caller hands over one by one: lists, generators, streams.

import { TraceCutError, illegal, inFrame, typeTag } from '../errors.js';
import { toRawFrame } from '../frames.js';

/**
 * A frame with its time.
 * @typedef {object} FrameAtTime
 * @property {import('../frames.js').FrameSource} frame
 * @property {number} [time] seconds; its number in the list and `frameRate` say when it is if not given
 * @property {number} [duration] for how long it is shown, in seconds, where that is known
 * @property {string} [name] for errors: the file that it is from
 * @property {string} [clip] which clip it is of: a frame of another than the one before begins anew, with a size, times
 *   from 0, objects and shots of its own
 */

/**
 * A frame of a list or a stream, with its time or without: then its number and `frameRate` say when it is.
 * @typedef {import('../frames.js').FrameSource | FrameAtTime} ListedFrame
 */

/**
 * @param {AsyncIterable<ListedFrame> | Iterable<ListedFrame | Promise<ListedFrame>> | ReadableStream<ListedFrame>} list
 * @param {{frameRate: number, loadDecoder: () => Promise<WebAssembly.Module>, maxPixels?: number}} options
 * @returns {import('./reader.js').Reader}
 */
export function openListed(list, { frameRate, loadDecoder, maxPixels }) {
  return {
    async info() {
      throw new TraceCutError(
        'unsupported',
        'a list or stream of frames has no facts before its frames are read; ask the frames themselves',
      );
    },
    async *frames() {
      let index = 0;
      let before = -Infinity;
      let begin = 0;
      /** @type {string | undefined} */
      let present;
      for await (const item of itemsOf(list)) {
        const at = index;
        const clip = clipOf(item, at);
        if (clip !== present) [present, begin, before] = [clip, at, -Infinity];
        const { frame, time, duration, name } = placed(item, at, at - begin, frameRate);
        if (!(time > before)) {
          closeFrame(frame);
          throw new TraceCutError(
            'data',
            `frame ${index} has time = ${time} s (expected more than ${before} s, the time of the frame before)`,
          );
        }
        before = time;
        index += 1;
        yield {
          time,
          duration: duration ?? 1 / frameRate,
          isGuess: duration === undefined,
          clip,
          read: () => readAs(toRawFrame(frame, loadDecoder, maxPixels), at, name),
          close: () => closeFrame(frame),
        };
      }
    },
    async times() {
      if (!Array.isArray(list) || list.some((item, index) => clipOf(item, index) !== undefined)) return null;
      return Float64Array.from(list, (item, index) => placed(item, index, index, frameRate).time);
    },
    close() {},
  };
}

/**
 * Streams are read through a reader: not every browser lets one iterate over them.
 * @param {AsyncIterable<ListedFrame> | Iterable<ListedFrame | Promise<ListedFrame>> | ReadableStream<ListedFrame>} list
 * @returns {AsyncGenerator<ListedFrame, void, unknown>}
 */
async function* itemsOf(list) {
  if (typeTag(list) !== 'ReadableStream') {
    yield* /** @type {AsyncIterable<ListedFrame>} */ (list);
    return;
  }
  const reader = /** @type {ReadableStream<ListedFrame>} */ (list).getReader();
  let ended = false;
  try {
    for (;;) {
      const { done, value } = await reader.read();
      ended = done;
      if (done) return;
      yield value;
    }
  } finally {
    if (!ended) reader.cancel().catch(() => {});
    reader.releaseLock();
  }
}

/**
 * @param {Promise<import('../frames.js').RawFrame>} reading
 * @param {number} index
 * @param {string | undefined} name
 * @returns {Promise<import('../frames.js').RawFrame>}
 */
async function readAs(reading, index, name) {
  try {
    const raw = await reading;
    return raw.kind === 'file' ? { ...raw, index, name: name ?? raw.name } : raw;
  } catch (error) {
    throw inFrame(error, { index, name });
  }
}

/**
 * @param {unknown} item
 * @param {number} index
 * @returns {string | undefined}
 */
function clipOf(item, index) {
  if (typeof item !== 'object' || item === null || !('frame' in item)) return undefined;
  const { clip } = /** @type {FrameAtTime} */ (item);
  if (clip !== undefined && typeof clip !== 'string') throw illegal('data', `clip of frame ${index}`, clip, 'a string');
  return clip;
}

/**
 * @param {unknown} item
 * @param {number} index
 * @param {number} place which frame of its clip it is
 * @param {number} frameRate
 * @returns {FrameAtTime & {time: number}}
 */
function placed(item, index, place, frameRate) {
  const otherwise = place / frameRate;
  if (typeof item === 'object' && item !== null && 'frame' in item) {
    const time = 'time' in item && item.time !== undefined ? item.time : otherwise;
    if (typeof time !== 'number' || !Number.isFinite(time)) {
      throw new TraceCutError('data', `time = ${String(time)} of frame ${index} (expected a number of seconds)`);
    }
    const { frame, duration, name } = /** @type {FrameAtTime} */ (item);
    if (duration !== undefined && !(duration > 0 && duration < Infinity))
      throw new TraceCutError('data', `duration = ${String(duration)} of frame ${index} (expected seconds, above 0)`);
    return { frame, time, duration, name };
  }
  if (typeTag(item) === 'VideoFrame')
    return { frame: /** @type {VideoFrame} */ (item), time: /** @type {VideoFrame} */ (item).timestamp / 1e6 };
  return { frame: /** @type {import('../frames.js').FrameSource} */ (item), time: otherwise };
}

/** @param {unknown} frame */
function closeFrame(frame) {
  if (typeTag(frame) === 'VideoFrame') /** @type {VideoFrame} */ (frame).close();
}
