// Segments several clips, one after the other; a clip that fails does not stop the others.

import { illegal } from '../check/errors.js';
import { type Damage, asOptions } from './reader.js';
import { type VideoOptions, type VideoProgress, segmentVideo } from './segment.js';
import type { VideoResult } from './result.js';
import type { VideoSource } from './source.js';

/** A clip of a queue. */
export interface QueuedClip {
  /** The caller's name of the clip. */
  name: string;
  /** Source for `segmentVideo`. */
  source: VideoSource;
  /** Removes the clip from the queue, before or while it runs. */
  signal?: AbortSignal;
}

/**
 * Outcome of a clip: its result, or the error that ended it (the signal's reason if that removed it); `damage` describes
 * the damage of its source, if the result contains the frames before it.
 */
export type SegmentedClip = {
  readonly index: number;
  readonly name: string;
  readonly result: VideoResult | null;
  readonly error: unknown;
  readonly damage: Damage | null;
};

/** Progress callback of a queue. */
export interface EachProgress {
  /** Called for each stage of each clip. */
  onProgress?: (progress: VideoProgress & { index: number; name: string }) => void;
}

/** Options for all clips, as for `segmentVideo`; `signal` ends the whole queue. */
export type EachOptions = Omit<VideoOptions, 'onProgress' | 'onDamage' | 'keep'> & EachProgress;

/**
 * Segments several clips, one after the other, and yields the outcome of each: a clip that fails, or that its own signal
 * removes, does not stop the others. The clips may be a generator: a queue that grows meanwhile.
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
  for (const name of ['onDamage', 'keep']) {
    if (name in rest)
      throw illegal('param', name, rest[name as keyof typeof rest], 'nothing: it is an option of segmentVideo alone');
  }
  if (onProgress !== undefined && typeof onProgress !== 'function')
    throw illegal('param', 'onProgress', onProgress, 'a function');
  let index = 0;
  for await (const clip of clips) {
    signal?.throwIfAborted();
    if (typeof clip !== 'object' || clip === null || typeof clip.name !== 'string')
      throw illegal('data', `clips[${index}]`, clip, 'an object {name, source}');
    const { name } = clip;
    let damage: Damage | null = null;
    const controller = new AbortController();
    const release = [signal, clip.signal].map((source) => linkSignal(source, controller));
    const clipIndex = index;
    // Invalid options are the caller's error, not the clip's.
    const video = segmentVideo(clip.source, {
      ...rest,
      signal: controller.signal,
      onDamage: (reported) => (damage = reported),
      onProgress: (progress) => onProgress?.({ index: clipIndex, name, ...progress }),
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

function linkSignal(signal: AbortSignal | undefined, controller: AbortController) {
  const abort = () => controller.abort(signal?.reason);
  if (signal?.aborted) abort();
  signal?.addEventListener('abort', abort, { once: true });
  return () => signal?.removeEventListener('abort', abort);
}
