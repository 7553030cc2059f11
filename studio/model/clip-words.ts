// A clip, and the part of it that is taken, in words.

import { WINDOW } from './clip-job.js';
import { fitSize } from './library.js';
import { DEFAULT_TAKE, type Source, type Take, endOf, kindOf, timeOf } from './source.js';
import { plural } from './words.js';

/**
 * What the user has put in. A take that went to the clip's end still does when its start or step is changed.
 * @param take the one before
 * @param isLength whether the number of frames was typed
 */
export function wantedTake(
  { frames, ...typed }: { start: number; frames: number; step: number; side: number },
  take: Take,
  source: Source | null,
  isLength: boolean,
): Take {
  const toEnd = !isLength && source !== null && take.start + take.frames * take.step >= source.count;
  const number = Number.isFinite(frames) ? Math.max(2, Math.round(frames)) : DEFAULT_TAKE.frames;
  return { ...typed, frames: toEnd ? source.count : number };
}

/** Returns the last frame of a take. */
export function lastOf({ start, frames, step }: Take): number {
  return start + (frames - 1) * step;
}

/** Returns `1.2 s`, `image 13`. */
export function placeIn(source: Source): (frame: number) => string {
  return (frame) => (source.kind === 'video' ? `${timeOf(source, frame).toFixed(1)}\u00a0s` : `image ${frame + 1}`);
}

/**
 * @param pace milliseconds per pixel and frame, 0 if not known
 * @returns what is taken, and how long that may last
 */
export function takeText(source: Source, take: Take, pace: number): string {
  const { width, height } = fitSize(source, take.side);
  const size = `${width} × ${height}`;
  const at = placeIn(source);
  const what =
    kindOf(source) === 'still'
      ? `Seen at ${size}`
      : `${plural(take.frames, 'frame')} of ${size}, ${at(take.start)} to ${at(lastOf(take))}`;
  const ms = pace * width * height * take.frames;
  const time = ms > 0 ? `About ${Math.max(1, Math.round(ms / 1000))}\u00a0s on this computer` : '';
  const windows =
    take.frames > WINDOW
      ? `More than ${WINDOW} frames are taken in windows; the first are shown while the others are computed`
      : '';
  return `${[what, time, windows].filter(Boolean).join('. ')}.`;
}

export function clipFacts(source: Source): string {
  const size = `${source.width} × ${source.height}`;
  if (source.kind === 'still') return size;
  if (source.kind === 'video')
    return `${size}, ${(endOf(source) - timeOf(source, 0)).toFixed(1)} s at ${Number(source.fps.toFixed(2))} fps`;
  return `${size}, ${plural(source.count, source.kind === 'images' ? 'image' : 'frame')}`;
}

/** Returns `0.5–1.7 s of 3.0 s`, `images 7–30 of 30`. */
export function partWords(source: Source, first: number, last: number): string {
  if (source.kind !== 'video') return `images ${first + 1}–${last + 1} of ${source.count}`;
  return `${timeOf(source, first).toFixed(1)}–${placeIn(source)(last)} of ${lengthOf(source)}`;
}

export function lengthOf(source: Source) {
  if (source.kind !== 'video') return `${source.count} images`;
  return `${endOf(source).toFixed(1)}\u00a0s`;
}
