// Options of videos: encoding quality, with an estimate of the size, and sound.

import { checkNumber, checkOptions, checkWholeNumber, illegal, typeTag } from '../../check/errors.js';

export type Codec = 'vp9' | 'vp8' | 'av1' | 'avc';

/** Encoding quality of a video. */
export type VideoQuality = 'low' | 'medium' | 'high' | 'very-high';

export const QUALITIES: readonly VideoQuality[] = ['low', 'medium', 'high', 'very-high'];

/** Quantizer for each quality and codec, on the codec's own scale. Chosen by eye. */
export const QUANTIZER: Record<VideoQuality, Partial<Record<Codec, number>>> = {
  low: { avc: 34, vp9: 44, av1: 176 },
  medium: { avc: 28, vp9: 36, av1: 144 },
  high: { avc: 22, vp9: 28, av1: 112 },
  'very-high': { avc: 16, vp9: 20, av1: 80 },
};

/**
 * Bits per pixel and frame, for encoders that need a bitrate instead; frames that need less use less. The H.264 encoders
 * of browsers are made for calls: they need more for the same quality. Chosen by eye.
 */
const BITS_PER_PIXEL: Record<VideoQuality, { avc: number; other: number }> = {
  low: { avc: 0.35, other: 0.06 },
  medium: { avc: 0.5, other: 0.12 },
  high: { avc: 0.75, other: 0.24 },
  'very-high': { avc: 1.2, other: 0.48 },
};

/** Bits per pixel and frame that videos from cameras took. */
const TYPICAL_BITS_PER_PIXEL: Record<VideoQuality, number> = { low: 0.16, medium: 0.2, high: 0.26, 'very-high': 0.36 };

/** Share of these bits that cut-out objects took, with their alpha. */
const CUTOUT_SHARE = 0.4;

/** Lowest bitrate in bits per second: small pictures need more bits per pixel. */
const MIN_BITRATE = 500_000;

/** Computes the bitrate, in bits per second. */
export function computeBitrate(
  quality: VideoQuality,
  codec: Codec,
  { width, height, frameRate }: { width: number; height: number; frameRate: number },
): number {
  const bits = BITS_PER_PIXEL[quality][codec === 'avc' ? 'avc' : 'other'];
  return Math.max(MIN_BITRATE, Math.round(bits * width * height * frameRate));
}

/** Properties of a video that are known before it is encoded. */
export interface VideoEstimate {
  /** Pixels in a row. */
  width: number;
  height: number;
  numFrames: number;
  /** Style as of `encodeVideo`; `overlay` if not given. */
  style?: 'overlay' | 'cutout' | 'masks' | 'alpha';
  /** Quality as of `encodeVideo`; `high` if not given. */
  quality?: VideoQuality;
}

/**
 * Estimates the size of the file that `encodeVideo` makes, in bytes. Depending on the pictures it may be three times as
 * large or a third.
 */
export function estimateVideoSize(video: VideoEstimate): number {
  const legal = ['width', 'height', 'numFrames', 'style', 'quality'];
  const { width, height, numFrames, style = 'overlay', quality = 'high' } = checkOptions(video, legal);
  checkWholeNumber('param', 'width', width, 1, 16384);
  checkWholeNumber('param', 'height', height, 1, 16384);
  checkNumber('numFrames', numFrames, 1, 10_000_000);
  if (!QUALITIES.includes(quality))
    throw illegal('param', 'quality', quality, QUALITIES.map((word) => `'${word}'`).join(', '));
  if (!['overlay', 'cutout', 'masks', 'alpha'].includes(style))
    throw illegal('param', 'style', style, "'overlay', 'cutout', 'masks', 'alpha'");
  const share = style === 'overlay' ? 1 : CUTOUT_SHARE;
  return Math.round((share * TYPICAL_BITS_PER_PIXEL[quality] * width * height * numFrames) / 8);
}

/** Source of the sound. */
export interface SoundOptions {
  /** Video file. */
  source: Blob | ArrayBuffer | Uint8Array;
  /** Start in seconds; the file's start if not given. */
  start?: number;
  /** End in seconds; the file's end if not given. */
  end?: number;
}

/** Checks the option `sound`; returns null if it is not given. */
export function checkSound(sound: unknown): Required<SoundOptions> | null {
  if (sound === undefined) return null;
  const legal = ['source', 'start', 'end'];
  const {
    source,
    start = 0,
    end = Infinity,
  } = checkOptions<SoundOptions>(sound as SoundOptions, legal, {
    prefix: 'sound.',
  });
  if (!['Blob', 'File', 'ArrayBuffer', 'Uint8Array'].includes(typeTag(source)))
    throw illegal('param', 'sound.source', source, 'a Blob, or the bytes of a file');
  if (typeof start !== 'number' || !(start >= 0)) throw illegal('param', 'sound.start', start, 'seconds, 0 or more');
  if (typeof end !== 'number' || !(end > start)) throw illegal('param', 'sound.end', end, `more than start = ${start}`);
  return { source, start, end };
}
