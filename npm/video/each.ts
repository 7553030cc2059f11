// Several clips, one after the other; one that fails stops nothing.

import { illegal } from '../check/errors.js';
import { type Damage, asOptions } from './reader.js';
import { type VideoOptions, type VideoProgress, segmentVideo } from './segment.js';
import type { VideoResult } from './result.js';
import type { VideoSource } from './source.js';

/** A clip of a queue. */
export interface QueuedClip {
  /** The caller's own. */
  name: string;
  /** What `segmentVideo` takes. */
  source: VideoSource;
  /** Takes it out of the queue, before it begins or on the way. */
  signal?: AbortSignal;
}

/**
 * What became of a clip: its result, or the error that ended it (the signal's reason where that took it out); `damage`
 * is what the source ended with, if the result is of the frames before that.
 */
export type SegmentedClip = {
  readonly index: number;
  readonly name: string;
  readonly result: VideoResult | null;
  readonly error: unknown;
  readonly damage: Damage | null;
};

/** How a queue reports. */
export interface EachProgress {
  /** Hears of each stage, and of which clip. */
  onProgress?: (progress: VideoProgress & { index: number; name: string }) => void;
}

/** Options for all clips, as of `segmentVideo`; `signal` ends the whole queue. */
export type EachOptions = Omit<VideoOptions, 'onProgress' | 'onDamage'> & EachProgress;

/**
 * Segments several clips, one after the other, and gives what became of each: a clip that fails, or that its own signal
 * takes out, stops no other. The clips may be a generator: a queue that grows on the way.
 *
 * ```js
 * for await (const { name, result, error } of segmentEach(files.map((file) => ({ name: file.name, source: file }))))
 *   console.log(name, error ?? result.objects.length);
 * ```
 */
export async function* segmentEach(
  clips: AsyncIterable<QueuedClip> | Iterable<QueuedClip>,
  options?: EachOptions,
): AsyncGenerator<SegmentedClip, void, undefined> {
  const { signal, onProgress, ...rest } = asOptions(options) as EachOptions;
  if (onProgress !== undefined && typeof onProgress !== 'function')
    throw illegal('param', 'onProgress', onProgress, 'a function');
  let index = 0;
  for await (const clip of clips) {
    signal?.throwIfAborted();
    if (typeof clip !== 'object' || clip === null || typeof clip.name !== 'string')
      throw illegal('data', `clips[${index}]`, clip, 'an object {name, source}');
    const { name } = clip;
    let damage: Damage | null = null;
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

function follow(signal: AbortSignal | undefined, controller: AbortController) {
  const abort = () => controller.abort(signal?.reason);
  if (signal?.aborted) abort();
  signal?.addEventListener('abort', abort, { once: true });
  return () => signal?.removeEventListener('abort', abort);
}
