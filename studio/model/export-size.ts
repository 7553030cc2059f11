// Sizes of exported results: the source's, half of it, the working size or another. Frames are read from the source
// again.

import { fitSize } from './library.js';
import { PageError } from './messages.js';
import type { ClipJob } from './clip-job.js';
import type { Picture, Source } from './source.js';

type Size = { width: number; height: number };
type SizeName = 'source' | 'half' | 'working' | 'own';

/** Largest difference of a frame's time between two reads, in seconds: rounding. */
const MAX_TIME_DIFFERENCE_S = 1e-6;

/** Shortest long side of an export, in pixels. */
export const MIN_SIDE_PX = 16;

/** Returns the distinct sizes to choose from. */
export function exportSizes(source: Source, working: Size): { name: SizeName; label: string; side: number }[] {
  const side = Math.max(source.width, source.height);
  const custom = { name: 'own' as const, label: 'Other…', side };
  const presets: [SizeName, string, number][] = [
    ['source', 'Same as source', side],
    ['half', 'Half', Math.round(side / 2)],
    ['working', 'Working size', Math.max(working.width, working.height)],
  ];
  const unique = presets.filter(
    ([, , size], k) => size >= MIN_SIDE_PX && presets.findIndex(([, , otherSize]) => otherSize === size) === k,
  );
  const sizes = unique.map(([name, presetLabel, longSide]) => {
    const { width, height } = fitSize(source, longSide);
    return { name, label: `${presetLabel}, ${width} × ${height}`, side: longSide };
  });
  return [...sizes, custom];
}

/**
 * Reads the frames of a result at another size.
 * @param side the long side, in pixels
 */
export function resizedFrames(
  { source, trim }: Pick<ClipJob, 'source' | 'trim'>,
  { numFrames, times }: { numFrames: number; times: ArrayLike<number> | null },
  side: number,
) {
  return {
    async *stream(signal: AbortSignal): AsyncGenerator<Picture, void, undefined> {
      let t = 0;
      const sized = { ...trim, frames: numFrames, side };
      for await (const picture of source.pictures?.(sized, signal) ?? source.frames(sized, signal)) {
        const { time } = picture;
        if (time !== null && times && Math.abs(time - times[t]) > MAX_TIME_DIFFERENCE_S)
          throw new PageError('other-frames', `frame ${t + 1} is at ${time} s and was at ${times[t]} s`);
        t += 1;
        yield picture;
      }
    },
    read: (t: number) => source.preview(trim.start + t * trim.step, side, times?.[t]),
  };
}

/**
 * @param fps used if frames have no times
 * @returns seconds from the start of the first frame to the end of the last, which is taken to last as long as the
 *   one before if unknown
 */
export function computeDuration(
  { numFrames, times, end = null }: { numFrames: number; times: ArrayLike<number> | null; end?: number | null },
  fps: number,
): number {
  if (times && end !== null) return end - times[0];
  if (!times || numFrames < 2) return numFrames / fps;
  const last = times[numFrames - 1];
  return 2 * last - times[numFrames - 2] - times[0];
}
