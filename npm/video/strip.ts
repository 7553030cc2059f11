// A few frames spread over a video, for a filmstrip.

import { TraceCutError, checkOptions, checkWholeNumber } from '../check/errors.js';
import { untilAborted } from '../worker/pause.js';
import { createDecoderLoader } from '../worker/remote.js';
import { toShownFrame } from './pixels.js';
import {
  TAKE_NAMES,
  TIME_TOLERANCE_S,
  type TakeOptions,
  type TimedFrame,
  createEmptyError,
  isDamage,
  splitTake,
} from './reader.js';
import { type DecodedFrame, type VideoSource, openReader } from './source.js';

/** Length of a strip. */
export interface StripCount {
  /** Most frames of the strip, 1 to 1000, 12 if not given. */
  count?: number;
}

/** Options of a strip; all but `count` are as for `videoFrames`. */
export type StripOptions = Omit<TakeOptions, 'step' | 'maxFrames'> & StripCount;

const LEGAL = [...TAKE_NAMES.filter((name) => name !== 'step' && name !== 'maxFrames'), 'decoder', 'count'];

/**
 * Yields a few frames of a video, evenly spread over it or over the range from `start` to `end`, in order, for a filmstrip.
 * A clip of fewer frames yields each once. Streams and generators have no strip: their length is unknown.
 *
 * ```js
 * for await (const { frame, time } of videoStrip(file, { count: 12, size: 96 })) console.log(time, frame);
 * ```
 */
export async function* videoStrip(
  source: VideoSource,
  options?: StripOptions,
): AsyncGenerator<DecodedFrame, void, undefined> {
  const { decoder, count = 12, ...takeOptions } = checkOptions(options ?? {}, LEGAL);
  checkWholeNumber('param', 'count', count, 1, 1000);
  const { take } = splitTake(takeOptions);
  take.signal?.throwIfAborted();
  const reader = await openReader(source, take, createDecoderLoader(decoder));
  try {
    const times = await untilAborted(reader.times(), take.signal);
    if (!times)
      throw new TraceCutError('unsupported', 'a stream or generator of frames has no strip: its length is unknown');
    const inRange = [...times].filter(
      (time) => time >= take.start - TIME_TOLERANCE_S && time < take.end - TIME_TOLERANCE_S,
    );
    const stripTimes = pickMiddles(inRange, count);
    if (stripTimes.length === 0) throw await createEmptyError(take, reader);
    const frames = reader.framesAt ? reader.framesAt(stripTimes) : pickFramesAt(reader.frames(take), stripTimes);
    let index = 0;
    try {
      for (;;) {
        const next = readPicture(frames.next(), take.size);
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
      take.onDamage({ frames: index, total: stripTimes.length, error });
    } finally {
      frames.return().catch(() => {});
    }
  } finally {
    reader.close();
  }
}

/** Reads the next frame, null after the last; closes it even if it is no longer awaited. */
async function readPicture(next: Promise<IteratorResult<TimedFrame, void>>, size: number | undefined) {
  const { value, done } = await next;
  if (done) return null;
  const { time, duration } = value;
  try {
    return { ...(await toShownFrame(await value.read(), size, time)), time, duration };
  } finally {
    value.close();
  }
}

/** Returns the middles of `count` equal parts; all times if there are fewer. */
function pickMiddles(times: number[], count: number): number[] {
  if (times.length <= count) return times;
  return Array.from({ length: count }, (_, k) => times[Math.floor(((k + 0.5) * times.length) / count)]!);
}

/**
 * Yields the frames at these times.
 * @param times ascending
 */
async function* pickFramesAt(
  frames: AsyncGenerator<TimedFrame, void, unknown>,
  times: number[],
): AsyncGenerator<TimedFrame, void, unknown> {
  let next = 0;
  for await (const frame of frames) {
    if (frame.time < times[next]! - TIME_TOLERANCE_S) frame.close();
    else {
      yield frame;
      next += 1;
      if (next >= times.length) return;
    }
  }
}
