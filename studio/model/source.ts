// Where frames come from: each kind of source answers the same questions, so the rest of the page does not care.

import type { VideoOptions } from './library.js';

/** What to take from a source. */
export interface Take {
  /** Index of the first frame. */
  start: number;
  frames: number;
  /** 1 takes every frame, 2 every second one, …. */
  step: number;
  /** Long side of the working size in pixels; a smaller source stays as it is. */
  side: number;
}

export interface Source {
  kind: 'sample' | 'video' | 'images' | 'still';
  name: string;
  /** In pixels. */
  width: number;
  height: number;
  /** Frames per second, on average; a convention for images. */
  fps: number;
  /** Frames there are (for a video: about). */
  count: number;
  /** One frame; found by its time in seconds where that is known. */
  preview: (frame: number, side: number, time?: number) => Promise<ImageData>;
  /**
   * `count` frames, or all where there are fewer, evenly spread, of at most this long side; what cannot be trimmed
   * has none.
   */
  strip?: (count: number, side: number, signal: AbortSignal) => AsyncIterable<ImageData>;
  /** Of all frames in seconds, where the file says them. */
  times?: ArrayLike<number> | null;
  /** When the last frame ends, in seconds, where the file says it. */
  end?: number;
  /** What `frames` ended with when it was last read: `frames` come before the damage, of `total`. */
  damage?: { frames: number; total: number | null } | null;
  /** The file of a video. */
  file?: File;
  /** Its media type, by its content. */
  type?: string;
  /** All that it was opened from; the sample has none. */
  files?: File[];
  /** With their times, and when they end, in seconds; null where nothing says. */
  frames: (
    take: Take,
    signal: AbortSignal,
  ) => AsyncIterable<{ frame: ImageData; time: number | null; end?: number | null }>;
  /** What `segmentVideo` reads by itself; of other sources it is given `frames`. */
  direct?: (take: Take) => { source: File; options: VideoOptions };
  close: () => void;
}

/** What is taken when nobody chooses, of as many frames as there are. */
export const DEFAULT_TAKE: Take = { start: 0, frames: 2, step: 1, side: 480 };

/** Returns whether the source has motion. */
export function kindOf(source: Source | null): 'clip' | 'still' {
  return source?.kind === 'still' ? 'still' : 'clip';
}

/** Returns the default take of a source. */
export function usualTake(source: Source): Take {
  const side = source.kind === 'sample' ? source.width : DEFAULT_TAKE.side;
  return fitTake({ ...DEFAULT_TAKE, frames: source.count, side }, source);
}

/** Clamps a take to what the source has. */
export function fitTake(take: Take, source: Source): Take {
  const start = Math.max(0, Math.min(take.start, source.count - 2));
  const room = Math.floor((source.count - 1 - start) / take.step) + 1;
  return { ...take, start, frames: Math.max(1, Math.min(take.frames, room)) };
}

/** Returns the time at which a take begins, in seconds. */
export function timeOf({ times, fps }: Source, frame: number): number {
  return times?.[frame] ?? frame / fps;
}

/** Returns the time at which the last frame of a take ends, in seconds. */
export function endOf({ count, fps, end = count / fps }: Source): number {
  return end;
}
