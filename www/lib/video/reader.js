// What every source of frames looks like from inside, and what is taken of it.

import { TraceCutError } from '../errors.js';
import { pixelsFrom } from './pixels.js';

/**
 * Facts of a video.
 * @typedef {object} VideoInfo
 * @property {number} width of the frames as they are shown, in pixels
 * @property {number} height
 * @property {number} duration seconds from the begin of the first frame to the end of the last; `Infinity` for a stream
 * @property {number} frameRate frames per second, on average where it changes; `NaN` where nothing says
 * @property {number} [numFrames] number of frames, where that can be known without decoding
 * @property {Float64Array | null} times of all frames in seconds, ascending, where these can be known; else null
 * @property {string | null} codec such as `'avc1.64001f'`; null where it is not known
 * @property {boolean} decodable whether frames can be had of it here
 */

/**
 * A frame that is not read yet: `read` copies its pixels, of no more than `size` where that is little work there, `close`
 * gives up whatever holds it, read or not.
 * @typedef {{time: number, duration: number, read: (size?: number) => Promise<import('../frames.js').RawFrame>, close: ()
 *   => void, isGuess?: boolean, clip?: string}} TimedFrame `isGuess` where nothing says how long it is shown; `clip`
 *   where it is of one of several
 */

/**
 * A source of frames. `frames` gives them in the order of their times, those before `start` left out or not; `times`
 * gives the times of all frames where they are known without decoding; `at` the frames at ascending times of frames,
 * where that takes less than going through all.
 * @typedef {object} Reader
 * @property {() => Promise<Omit<VideoInfo, 'times'>>} info
 * @property {(range: {start: number, end: number}) => AsyncGenerator<TimedFrame, void, unknown>} frames
 * @property {() => Promise<Float64Array | null>} times
 * @property {(times: number[]) => AsyncGenerator<TimedFrame, void, unknown>} [at]
 * @property {TraceCutError} [damage] what the source ends with, where that is known before it is read
 * @property {() => void} close
 */

/**
 * `end` is when a frame ends, in seconds; null where nothing says.
 * @typedef {{raw: import('../frames.js').RawFrame, index: number, time: number, duration: number, end: number | null,
 *   clip?: string}} TakenFrame
 */

/**
 * Times are often sums of rounded numbers: a frame this much before `start` is still in. WebCodecs counts microseconds.
 */
export const SLACK = 1e-6;

/** What damage is called, and how many frames before it are worth having: motion needs two. */
const DAMAGE = ['truncated', 'decode', 'frame-bytes'];
const FEWEST = 2;

/**
 * The frames of a reader that are wanted, as pixels; each is closed as soon as it is read. Where the take knows what to
 * do with damage, they end before it.
 * @param {Reader} reader
 * @param {import('./options.js').Take} take
 * @returns {AsyncGenerator<TakenFrame, void, unknown>}
 */
export async function* taken(reader, take) {
  let index = 0;
  try {
    for await (const frame of wanted(reader, take)) {
      yield frame;
      index += 1;
    }
    if (reader.damage && index < take.maxFrames && take.end === Infinity) throw reader.damage;
  } catch (error) {
    if (!take.onDamage || !isDamage(error) || index < FEWEST) throw error;
    take.onDamage({ frames: index, total: await expected(reader, take).catch(() => null), error });
  }
}

/**
 * @param {unknown} error
 * @returns {error is TraceCutError}
 */
export function isDamage(error) {
  return error instanceof TraceCutError && DAMAGE.includes(error.code);
}

/**
 * @param {Reader} reader
 * @param {import('./options.js').Take} take
 * @returns {AsyncGenerator<TakenFrame, void, unknown>}
 */
async function* wanted(reader, take) {
  let passed = 0;
  let index = 0;
  /** @type {string | undefined} */
  let present;
  for await (const frame of reader.frames(take)) {
    try {
      if (frame.time < take.start - SLACK) continue;
      const { clip } = frame;
      if (frame.time >= take.end - SLACK) {
        if (clip === undefined) return;
        continue;
      }
      if (clip !== present) [present, passed] = [clip, 0];
      passed += 1;
      if ((passed - 1) % take.step !== 0) continue;
      const read = await frame.read(take.size);
      frame.close();
      // Whether a file is damaged shows when it is decoded.
      const raw = take.onDamage && read.kind === 'file' ? await decoded(read) : read;
      const { time, duration } = frame;
      // Frames that are left out lengthen those before them; nobody knows how many would have come after the last.
      const isKnown = duration > 0 && !frame.isGuess && take.step === 1;
      yield {
        raw,
        index,
        time,
        duration,
        end: isKnown ? time + duration : null,
        ...(clip === undefined ? {} : { clip }),
      };
      index += 1;
      if (index >= take.maxFrames) return;
    } finally {
      frame.close();
    }
  }
}

/**
 * @param {import('../frames.js').RawFrame} raw
 * @returns {Promise<import('../frames.js').RawFrame>}
 */
async function decoded(raw) {
  return { kind: 'pixels', ...(await pixelsFrom(raw)) };
}

/**
 * How many frames `taken` will give, where that can be known.
 * @param {Reader} reader
 * @param {import('./options.js').Take} take
 * @returns {Promise<number | null>}
 */
export async function expected(reader, { start, end, step, maxFrames }) {
  const times = await reader.times();
  if (!times) return null;
  const inRange = times.filter((time) => time >= start - SLACK && time < end - SLACK).length;
  return Math.min(maxFrames, Math.ceil(inRange / step));
}

/**
 * The error of a take that holds nothing.
 * @param {import('./options.js').Take} take
 * @param {Reader} reader
 */
export async function nothingTaken({ start, end }, reader) {
  if (start === -Infinity && end === Infinity) return new TraceCutError('no-frames', 'the source has no frames');
  const times = await reader.times().catch(() => null);
  const last = times?.[times.length - 1];
  const known = times && last !== undefined ? `; its frames are at ${round(times[0])} s to ${round(last)} s` : '';
  const range = `${start > -Infinity ? ` from ${start} s` : ''}${end < Infinity ? ` to ${end} s` : ' on'}`;
  return new TraceCutError('no-frames', `the source has no frame${range}${known}`);
}

/** @param {number | undefined} time */
const round = (time = 0) => Number(time.toFixed(3));

/**
 * What `promise` gives, unless the signal aborts first.
 * @template T
 * @param {Promise<T>} promise
 * @param {AbortSignal | undefined} signal
 * @returns {Promise<T>}
 */
export function unlessAborted(promise, signal) {
  if (!signal) return promise;
  return new Promise((resolve, reject) => {
    const abort = () => reject(signal.reason);
    if (signal.aborted) abort();
    signal.addEventListener('abort', abort, { once: true });
    promise.then(resolve, reject).finally(() => signal.removeEventListener('abort', abort));
  });
}
