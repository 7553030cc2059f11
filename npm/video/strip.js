// A few frames spread over a video, for a filmstrip.

import { TraceCutError, illegal, wholeNumber } from '../check/errors.js';
import { untilAborted } from '../worker/pause.js';
import { decoderLoader } from '../worker/remote.js';
import { shownFrame } from './pixels.js';
import { SLACK, asOptions, isDamage, nothingTaken, splitTake } from './reader.js';
import { openReader } from './source.js';

/**
 * The length of a strip.
 * @typedef {object} StripCount
 * @property {number} [count] how many frames the strip has at most, 1 to 1000, 12 if not given
 */

/**
 * What a strip shows; the other options are as for `videoFrames`.
 * @typedef {Omit<import('./reader.js').TakeOptions, 'step' | 'maxFrames'> & StripCount} StripOptions
 */

/**
 * A few frames of a video, evenly spread over it or over the part from `start` to `end`, in order: what a filmstrip
 * shows. A clip of fewer frames gives each once. A stream, and frames that a generator gives, have no strip: their
 * length is not known.
 *
 * ```js
 * for await (const { frame, time } of videoStrip(file, { count: 12, size: 96 })) console.log(time, frame);
 * ```
 * @param {import('./source.js').VideoSource} source
 * @param {StripOptions} [options]
 * @returns {AsyncGenerator<import('./source.js').DecodedFrame, void, undefined>}
 */
export async function* videoStrip(source, options) {
  const { decoder, count = 12, ...given } = asOptions(options);
  wholeNumber('param', 'count', count, 1, 1000);
  const { take, others } = splitTake(given);
  const stray = [
    ...Object.keys(others),
    ...Object.keys(given).filter((name) => name === 'step' || name === 'maxFrames'),
  ][0];
  if (stray)
    throw illegal('param', stray, given[stray], 'count, start, end, size, frameRate, decoder, signal or onDamage');
  take.signal?.throwIfAborted();
  const wasm = /** @type {import('../check/options.js').WasmSource | undefined} */ (decoder);
  const reader = await openReader(source, take, decoderLoader(wasm));
  try {
    const times = await untilAborted(reader.times(), take.signal);
    if (!times)
      throw new TraceCutError('unsupported', 'a stream or generator of frames has no strip: its length is not known');
    const inRange = [...times].filter((time) => time >= take.start - SLACK && time < take.end - SLACK);
    const wanted = spread(inRange, /** @type {number} */ (count));
    if (wanted.length === 0) throw await nothingTaken(take, reader);
    const frames = reader.at ? reader.at(wanted) : only(reader.frames(take), wanted);
    let index = 0;
    try {
      for (;;) {
        const next = pictureOf(frames.next(), take.size);
        const picture = await untilAborted(next, take.signal).catch((error) => {
          next.then((late) => late?.close()).catch(() => {});
          throw error;
        });
        if (!picture) return;
        const { close, ...shown } = picture;
        try {
          yield { index, ...shown };
        } finally {
          close();
        }
        index += 1;
      }
    } catch (error) {
      if (!take.onDamage || !isDamage(error) || index === 0) throw error;
      take.onDamage({ frames: index, total: wanted.length, error });
    } finally {
      frames.return().catch(() => {});
    }
  } finally {
    reader.close();
  }
}

/**
 * The next frame as a picture, null after the last; it is closed also where nobody waits for it any more.
 * @param {Promise<IteratorResult<import('./reader.js').TimedFrame, void>>} next
 * @param {number | undefined} size
 */
async function pictureOf(next, size) {
  const { value, done } = await next;
  if (done) return null;
  const { time, duration } = value;
  try {
    return { ...(await shownFrame(await value.read(), size, time)), time, duration };
  } finally {
    value.close();
  }
}

/**
 * The middles of `count` equal parts; everything where there is less.
 * @param {number[]} times
 * @param {number} count
 * @returns {number[]}
 */
function spread(times, count) {
  if (times.length <= count) return times;
  return Array.from(
    { length: count },
    (_, k) => /** @type {number} */ (times[Math.floor(((k + 0.5) * times.length) / count)]),
  );
}

/**
 * @param {AsyncGenerator<import('./reader.js').TimedFrame, void, unknown>} frames in order
 * @param {number[]} times ascending
 * @returns {AsyncGenerator<import('./reader.js').TimedFrame, void, unknown>} those at these times
 */
async function* only(frames, times) {
  let next = 0;
  for await (const frame of frames) {
    if (frame.time < /** @type {number} */ (times[next]) - SLACK) frame.close();
    else {
      yield frame;
      next += 1;
      if (next >= times.length) return;
    }
  }
}
