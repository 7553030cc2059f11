// A few frames spread over a video, for a filmstrip.

import { TraceCutError, illegal, wholeNumber } from '../check/errors.js';
import { untilAborted } from '../worker/pause.js';
import { decoderLoader } from '../worker/remote.js';
import { shownFrame } from './pixels.js';
import { SLACK, type TakeOptions, type TimedFrame, asOptions, isDamage, nothingTaken, splitTake } from './reader.js';
import { type DecodedFrame, type VideoSource, openReader } from './source.js';
import type { WasmSource } from '../check/options.js';

/** The length of a strip. */
export interface StripCount {
  /** How many frames the strip has at most, 1 to 1000, 12 if not given. */
  count?: number;
}

/** What a strip shows; the other options are as for `videoFrames`. */
export type StripOptions = Omit<TakeOptions, 'step' | 'maxFrames'> & StripCount;

/**
 * A few frames of a video, evenly spread over it or over the part from `start` to `end`, in order: what a filmstrip
 * shows. A clip of fewer frames gives each once. A stream, and frames that a generator gives, have no strip: their
 * length is not known.
 *
 * ```js
 * for await (const { frame, time } of videoStrip(file, { count: 12, size: 96 })) console.log(time, frame);
 * ```
 */
export async function* videoStrip(
  source: VideoSource,
  options?: StripOptions,
): AsyncGenerator<DecodedFrame, void, undefined> {
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
  const reader = await openReader(source, take, decoderLoader(decoder as WasmSource | undefined));
  try {
    const times = await untilAborted(reader.times(), take.signal);
    if (!times)
      throw new TraceCutError('unsupported', 'a stream or generator of frames has no strip: its length is not known');
    const inRange = [...times].filter((time) => time >= take.start - SLACK && time < take.end - SLACK);
    const wanted = spread(inRange, count as number);
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

/** The next frame as a picture, null after the last; it is closed also where nobody waits for it any more. */
async function pictureOf(next: Promise<IteratorResult<TimedFrame, void>>, size: number | undefined) {
  const { value, done } = await next;
  if (done) return null;
  const { time, duration } = value;
  try {
    return { ...(await shownFrame(await value.read(), size, time)), time, duration };
  } finally {
    value.close();
  }
}

/** The middles of `count` equal parts; everything where there is less. */
function spread(times: number[], count: number): number[] {
  if (times.length <= count) return times;
  return Array.from({ length: count }, (_, k) => times[Math.floor(((k + 0.5) * times.length) / count)]!);
}

/**
 * @param times ascending
 * @returns those at these times
 */
async function* only(
  frames: AsyncGenerator<TimedFrame, void, unknown>,
  times: number[],
): AsyncGenerator<TimedFrame, void, unknown> {
  let next = 0;
  for await (const frame of frames) {
    if (frame.time < times[next]! - SLACK) frame.close();
    else {
      yield frame;
      next += 1;
      if (next >= times.length) return;
    }
  }
}
