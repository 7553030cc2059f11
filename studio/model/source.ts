// Sources of frames, with one interface for all kinds.

import type { EncodeFrame, PixelFrame, VideoOptions } from './library.js';

/** The frames of a source to process, and their size. */
export interface Trim {
  /** Index of the first frame. */
  start: number;
  frames: number;
  /** 1 takes every frame, 2 every second one, …. */
  step: number;
  /** Long side of the working size in pixels; a smaller source stays as it is. */
  side: number;
}

/** A frame to draw, valid until the next one is requested; `pixels` copies those that are not in memory. */
export type Picture = { frame: EncodeFrame; time: number | null; pixels?: () => Promise<PixelFrame> };

export interface Source {
  kind: 'sample' | 'video' | 'images';
  name: string;
  /** In pixels. */
  width: number;
  height: number;
  /** Frames per second, on average; a convention for images. */
  fps: number;
  /** Number of frames; approximate for videos. */
  count: number;
  /** Reads one frame, by its time in seconds if known. */
  preview: (frame: number, side: number, time?: number) => Promise<ImageData>;
  /** Reads up to `count` evenly spaced frames for the filmstrip; absent if the source cannot be trimmed. */
  strip?: (count: number, side: number, signal: AbortSignal) => AsyncIterable<ImageData>;
  /** Times of all frames in seconds, if known. */
  times?: ArrayLike<number> | null;
  /** End of the last frame in seconds, if known. */
  end?: number;
  /** Damage found when it was last read: `frames` of `total` could be read. */
  damage?: { frames: number; total: number | null } | null;
  /** The file of a video. */
  file?: File;
  /** Media type, detected from the content. */
  type?: string;
  /** The opened files; absent for the sample. */
  files?: File[];
  /** Reads frames with their times and ends in seconds; null if unknown. */
  frames: (
    trim: Trim,
    signal: AbortSignal,
  ) => AsyncIterable<{ frame: ImageData; time: number | null; end?: number | null }>;
  /** Reads frames for drawing; `frames` does if absent. */
  pictures?: (trim: Trim, signal: AbortSignal) => AsyncIterable<Picture>;
  /** Returns what `segmentVideo` can read directly; otherwise it is given `frames`. */
  direct?: (trim: Trim) => { source: File; options: VideoOptions };
  close: () => void;
}

/** The default trim before the number of frames is known. */
export const DEFAULT_TRIM: Trim = { start: 0, frames: 2, step: 1, side: 480 };

export function defaultTrim(source: Source): Trim {
  const side = source.kind === 'sample' ? source.width : DEFAULT_TRIM.side;
  return clampTrim({ ...DEFAULT_TRIM, frames: source.count, side }, source);
}

export function clampTrim(trim: Trim, source: Source): Trim {
  const start = Math.max(0, Math.min(trim.start, source.count - 2));
  const room = Math.floor((source.count - 1 - start) / trim.step) + 1;
  return { ...trim, start, frames: Math.max(1, Math.min(trim.frames, room)) };
}

/** Returns the time of a frame in seconds. */
export function frameTime({ times, fps }: Source, frame: number): number {
  return times?.[frame] ?? frame / fps;
}

/** Returns the end of the source in seconds. */
export function endTime({ count, fps, end = count / fps }: Source): number {
  return end;
}
