// Texts about a clip and its trim.

import { WINDOW } from './clip-job.js';
import { fitSize } from './library.js';
import { DEFAULT_TRIM, type Source, type Trim, endTime, frameTime } from './source.js';
import { formatPlural } from './messages.js';

/**
 * Returns the trim that the inputs stand for. A trim to the end of the clip stays so when its start or step changes.
 * @param trim the previous one
 * @param isLength true if the number of frames was typed
 */
export function trimFromInputs(
  { frames, ...typed }: { start: number; frames: number; step: number; side: number },
  trim: Trim,
  source: Source | null,
  isLength: boolean,
): Trim {
  const toEnd = !isLength && source !== null && trim.start + trim.frames * trim.step >= source.count;
  const number = Number.isFinite(frames) ? Math.max(2, Math.round(frames)) : DEFAULT_TRIM.frames;
  return { ...typed, frames: toEnd ? source.count : number };
}

/** Returns the index of the last frame of a trim. */
export function lastFrame({ start, frames, step }: Trim): number {
  return start + (frames - 1) * step;
}

/** Returns a function that formats a frame's position: `1.2 s`, `image 13`. */
export function frameFormatter(source: Source): (frame: number) => string {
  return (frame) => (source.kind === 'video' ? `${frameTime(source, frame).toFixed(1)}\u00a0s` : `image ${frame + 1}`);
}

/**
 * @param pace milliseconds per pixel and frame, 0 if not known
 * @returns the frames, their size and the estimated time
 */
export function describeTrim(source: Source, trim: Trim, pace: number): string {
  const { width, height } = fitSize(source, trim.side);
  const size = `${width} × ${height}`;
  const at = frameFormatter(source);
  const extent = `${formatPlural(trim.frames, 'frame')} of ${size}, ${at(trim.start)} to ${at(lastFrame(trim))}`;
  const ms = pace * width * height * trim.frames;
  const time = ms > 0 ? `About ${Math.max(1, Math.round(ms / 1000))}\u00a0s on this computer` : '';
  const windows = trim.frames > WINDOW ? 'First results appear while the rest is computed' : '';
  return `${[extent, time, windows].filter(Boolean).join('. ')}.`;
}

export function describeClip(source: Source): string {
  const size = `${source.width} × ${source.height}`;
  if (source.kind === 'video')
    return `${size}, ${(endTime(source) - frameTime(source, 0)).toFixed(1)} s at ${Number(source.fps.toFixed(2))} fps`;
  return `${size}, ${formatPlural(source.count, source.kind === 'images' ? 'image' : 'frame')}`;
}

/** Returns `0.5–1.7 s of 3.0 s`, `images 7–30 of 30`. */
export function describePart(source: Source, first: number, last: number): string {
  if (source.kind !== 'video') return `images ${first + 1}–${last + 1} of ${source.count}`;
  return `${frameTime(source, first).toFixed(1)}–${frameFormatter(source)(last)} of ${describeLength(source)}`;
}

export function describeLength(source: Source) {
  if (source.kind !== 'video') return `${source.count} images`;
  return `${endTime(source).toFixed(1)}\u00a0s`;
}
