// Texts of the save dialog: size, length, sound, kept objects, and progress.

import { type SoundInfo, type VideoQuality, estimateVideoSize } from './library.js';
import { computeDuration } from './export-size.js';
import { formatBytes, formatCount, formatPlural, formatTimeLeft } from './messages.js';
import { objectName } from './palette.js';
import type { Subject } from './export.js';

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
