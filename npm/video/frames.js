// Decoding alone: the frames of a source with their times, and facts about it.

import { illegal } from '../check/errors.js';
import { decoderLoader } from '../worker/remote.js';
import { shownFrame } from './pixels.js';
import { asOptions, nothingTaken, splitTake, taken } from './reader.js';
import { openReader } from './source.js';

/**
 * A decoded frame, its number among those taken, and when and how long it is shown, in seconds; `clip` where the source has
 * several.
 * @typedef {import('./pixels.js').ShownFrame & {readonly index: number, readonly time: number, readonly duration: number,
 *   readonly clip?: string}} DecodedFrame
 */

/**
 * The pictures that a video holds, as a canvas draws them: each once, in the order in which they are shown, upright, in square pixels, of the
 * size of the first, with its time and duration in seconds as the file says them; docs/frames.md has the rules.
 * Nothing is read before the first is asked for, and leaving the loop closes the source. Of a file that is cut off or
 * damaged the frames before come; then `onDamage` is told, or an error ends the loop (`truncated`).
 * @param {import('./source.js').VideoSource} source
 * @param {import('./reader.js').TakeOptions} [options]
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
export function videoFrames(source, options) {
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
  return decoded(
    source,
    take,
    decoderLoader(/** @type {import('../check/options.js').WasmSource | undefined} */ (decoder)),
  );
}

/**
 * @param {unknown} source
 * @param {import('./reader.js').Take} take
 * @param {() => Promise<WebAssembly.Module>} loadDecoder
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
async function* decoded(source, take, loadDecoder) {
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
 * @param {import('./source.js').VideoSource} source
 * @param {Pick<import('./reader.js').TakeOptions, 'onDamage'>} [options]
 * @returns {Promise<import('./reader.js').VideoInfo>}
 */
export async function videoInfo(source, options) {
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
