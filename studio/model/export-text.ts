// Choices of the save dialog: sizes of exports (the source's, half of it, the working size or another), and texts about size,
// length, sound, kept objects and progress.

import { estimateVideoSize, fitSize, type SoundInfo, type VideoQuality } from './library.js';
import { formatBytes, formatCount, formatPlural, formatTimeLeft, PageError } from './messages.js';
import { objectName } from './palette.js';
import type { ClipJob } from './clip-job.js';
import type { Picture, Source } from './source.js';
import type { Subject } from './export.js';

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

const FORMATS = { webm: 'WebM', mp4: 'MP4' } as const;

const CODECS: Record<string, string> = {
  aac: 'AAC',
  opus: 'Opus',
  mp3: 'MP3',
  vorbis: 'Vorbis',
  flac: 'FLAC',
  ac3: 'AC-3',
  eac3: 'E-AC-3',
};

/** Returns the size and the number of frames of images. */
export function describeImages({ width, height }: { width: number; height: number }, numFrames: number): string {
  return `${width} × ${height}, ${formatPlural(numFrames, 'frame')}`;
}

/** Returns the size, the length and the estimated bytes of a video. */
export function describeVideo(
  { width, height }: { width: number; height: number },
  { masks, fps }: Pick<Subject, 'masks' | 'fps'>,
  quality: VideoQuality,
): string {
  const bytes = estimateVideoSize({ width, height, numFrames: masks.numFrames, quality });
  const seconds = `${computeDuration(masks, fps).toFixed(1)}\u00a0s`;
  return `${width} × ${height}, ${seconds}, about ${formatBytes(bytes)}`;
}

/** Returns which formats can hold the sound, and as what. */
export function describeSound(sound: Pick<SoundInfo, 'codec' | 'formats' | 'converted'> | null): string {
  if (!sound) return '';
  const name = CODECS[sound.codec] ?? sound.codec;
  const without = Object.keys(FORMATS).filter((format) => !sound.formats.includes(format as 'mp4'));
  const names = (without.length > 0 ? without : sound.converted).map((format) => FORMATS[format as 'mp4']);
  if (names.length === 0) return `${name}, unchanged.`;
  const formats = names.length > 1 ? `${names[0]} and ${names[1]}` : String(names[0]);
  if (without.length === 0) return `${name}, unchanged; Opus in ${formats}.`;
  return `${name}, unchanged; no sound in ${formats}.`;
}

/** Returns which objects are saved; empty for all of them. */
export function describeKept({ kept, all }: { kept: number[]; all: number }): string {
  if (kept.length === all) return '';
  if (kept.length === 0) return 'Nothing is selected: the file would be empty.';
  return `Only ${kept.map(objectName).join(', ')} will be saved.`;
}

/** Returns the progress of an export; empty before its first step. */
export function describeProgress({ done, total }: { done: number; total: number }, msLeft: number | null): string {
  if (total === 0) return '';
  const text = total === 1 ? `${done} of 1 frame` : `${done} of ${formatCount(total)} frames`;
  return msLeft === null ? text : `${text}, ${formatTimeLeft(msLeft)}`;
}
