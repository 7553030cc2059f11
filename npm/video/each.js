// Several clips, one after the other; one that fails stops nothing.

import { illegal } from '../check/errors.js';
import { asOptions } from './reader.js';
import { segmentVideo } from './segment.js';

/**
 * A clip of a queue.
 * @typedef {object} QueuedClip
 * @property {string} name the caller's own
 * @property {import('./source.js').VideoSource} source what `segmentVideo` takes
 * @property {AbortSignal} [signal] takes it out of the queue, before it begins or on the way
 */

/**
 * What became of a clip: its result, or the error that ended it (the signal's reason where that took it out); `damage`
 * is what the source ended with, if the result is of the frames before that.
 * @typedef {{readonly index: number, readonly name: string, readonly result: import('./result.js').VideoResult | null,
 *   readonly error: unknown, readonly damage:
 *   import('./reader.js').Damage | null}} SegmentedClip
 */

/**
 * How a queue reports.
 * @typedef {object} EachProgress
 * @property {(progress: import('./segment.js').VideoProgress & {index: number, name: string}) => void} [onProgress]
 *   hears
 *   of each stage, and of which clip
 */

/**
 * Options for all clips, as of `segmentVideo`; `signal` ends the whole queue.
 * @typedef {Omit<import('./segment.js').VideoOptions, 'onProgress' | 'onDamage'> & EachProgress} EachOptions
 */

/**
 * Segments several clips, one after the other, and gives what became of each: a clip that fails, or that its own signal
 * takes out, stops no other. The clips may be a generator: a queue that grows on the way.
 *
 * ```js
 * for await (const { name, result, error } of segmentEach(files.map((file) => ({ name: file.name, source: file }))))
 *   console.log(name, error ?? result.objects.length);
 * ```
 * @param {AsyncIterable<QueuedClip> | Iterable<QueuedClip>} clips
 * @param {EachOptions} [options]
 * @returns {AsyncGenerator<SegmentedClip, void, undefined>}
 */
export async function* segmentEach(clips, options) {
  const { signal, onProgress, ...rest } = /** @type {EachOptions} */ (asOptions(options));
  if (onProgress !== undefined && typeof onProgress !== 'function')
    throw illegal('param', 'onProgress', onProgress, 'a function');
  let index = 0;
  for await (const clip of clips) {
    signal?.throwIfAborted();
    if (typeof clip !== 'object' || clip === null || typeof clip.name !== 'string')
      throw illegal('data', `clips[${index}]`, clip, 'an object {name, source}');
    const { name } = clip;
    /** @type {import('./reader.js').Damage | null} */
    let damage = null;
    const stop = new AbortController();
    const release = [signal, clip.signal].map((one) => follow(one, stop));
    const at = index;
    // Options that are wrong are the caller's error, not the clip's.
    const video = segmentVideo(clip.source, {
      ...rest,
      signal: stop.signal,
      onDamage: (told) => (damage = told),
      onProgress: (progress) => onProgress?.({ index: at, name, ...progress }),
    });
    try {
      const result = await video.collect();
      yield { index, name, result, error: null, damage };
    } catch (error) {
      signal?.throwIfAborted();
      yield { index, name, result: null, error, damage: null };
    } finally {
      for (const end of release) end();
    }
    index += 1;
  }
}

/**
 * @param {AbortSignal | undefined} signal
 * @param {AbortController} controller aborted with it
 */
function follow(signal, controller) {
  const abort = () => controller.abort(signal?.reason);
  if (signal?.aborted) abort();
  signal?.addEventListener('abort', abort, { once: true });
  return () => signal?.removeEventListener('abort', abort);
}
