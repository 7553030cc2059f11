// Sources of frames with their trims, and the files that make one: a video, or images in the order of their names.

import { type EncodeFrame, type PixelFrame, sortFiles, type VideoOptions } from './library.js';
import { PageError } from './messages.js';

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

/** Files of one clip; `type` is the media type of the first. */
export type ClipFiles = { kind: 'video' | 'images'; files: File[]; type: string };

/** Sorts files by their names and rejects those that make no clip. */
export async function sortClipFiles(files: File[]): Promise<ClipFiles> {
  const sorted = await sortFiles(files);
  const unknown = sorted.find(({ kind }) => kind === null)?.file;
  if (sorted.length === 0 || unknown) throw new PageError('unknown-file', describeUnknown(unknown));
  const areImages = sorted.every(({ kind }) => kind === 'image');
  if (!areImages && sorted.length > 1) {
    const code = sorted.some(({ kind }) => kind === 'image') ? 'mixed-files' : 'many-videos';
    throw new PageError(code, `${sorted.length} files`);
  }
  return { kind: areImages ? 'images' : 'video', files: sorted.map(({ file }) => file), type: sorted[0].type ?? '' };
}

function describeUnknown(file?: File): string {
  if (!file) return '';
  return file.size === 0 ? `${file.name} is empty` : file.name;
}
