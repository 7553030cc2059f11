// At which size results are saved: the source's, half of it, the computation's, or another. Frames are read
// from the source again, one by one.

import { fitSize } from './library.js';
import { PageError } from './words.js';
import type { AnyJob } from './job.js';
import type { Source } from './source.js';

type Size = { width: number; height: number };
type SizeName = 'source' | 'half' | 'working' | 'own';

/** Times of one frame that was read twice may differ by so much, in seconds. */
const SLACK = 1e-6;

/** Shorter sides are of no use. */
export const LEAST_SIDE = 16;

/** Returns the sizes to choose from, each once. */
export function sizesOf(source: Source, working: Size): { name: SizeName; label: string; side: number }[] {
  const side = Math.max(source.width, source.height);
  const own = { name: 'own' as const, label: 'Other…', side };
  const named: [SizeName, string, number][] = [
    ['source', 'As the source', side],
    ['half', 'Half of it', Math.round(side / 2)],
    ['working', 'As computed', Math.max(working.width, working.height)],
  ];
  const there = named.filter(
    ([, , one], k) => one >= LEAST_SIDE && named.findIndex(([, , other]) => other === one) === k,
  );
  const sizes = there.map(([name, words, one]) => {
    const { width, height } = fitSize(source, one);
    return { name, label: `${words}, ${width} × ${height}`, side: one };
  });
  return [...sizes, own];
}

/**
 * The frames of a result, at another size.
 * @param side the longer one, in pixels
 */
export function framesOf(
  { source, take }: Pick<AnyJob, 'source' | 'take'>,
  { numFrames, times }: { numFrames: number; times: ArrayLike<number> | null },
  side: number,
) {
  return {
    async *all(signal: AbortSignal) {
      let t = 0;
      for await (const { frame, time } of source.frames({ ...take, frames: numFrames, side }, signal)) {
        if (time !== null && times && Math.abs(time - times[t]) > SLACK)
          throw new PageError('other-frames', `frame ${t + 1} is at ${time} s and was at ${times[t]} s`);
        t += 1;
        yield frame;
      }
    },
    one: (t: number) => source.preview(take.start + t * take.step, side, times?.[t]),
  };
}

/**
 * @param fps where frames have no times
 * @returns seconds from the first frame's begin to the last one's end, which lasts as long as the one before where
 *   nobody knows
 */
export function durationOf(
  { numFrames, times, end = null }: { numFrames: number; times: ArrayLike<number> | null; end?: number | null },
  fps: number,
): number {
  if (times && end !== null) return end - times[0];
  if (!times || numFrames < 2) return numFrames / fps;
  const last = times[numFrames - 1];
  return 2 * last - times[numFrames - 2] - times[0];
}
