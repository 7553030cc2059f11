// How finely videos are encoded, and about how large they become.

import { checkNumber, checkedOptions, illegal, wholeNumber } from '../../check/errors.js';

export type Codec = 'vp9' | 'vp8' | 'av1' | 'avc';

/** How finely a video is encoded. */
export type VideoQuality = 'low' | 'medium' | 'high' | 'very-high';

export const QUALITIES: readonly VideoQuality[] = ['low', 'medium', 'high', 'very-high'];

/** For each quality how coarsely each codec may round, on its own scale. */
export const QUANTIZER: Record<VideoQuality, Partial<Record<Codec, number>>> = {
  low: { avc: 34, vp9: 44, av1: 176 },
  medium: { avc: 28, vp9: 36, av1: 144 },
  high: { avc: 22, vp9: 28, av1: 112 },
  'very-high': { avc: 16, vp9: 20, av1: 80 },
};

/**
 * Bits for each pixel of each frame, where an encoder wants to know that instead; what a frame does not need it does not
 * take. H.264 encoders of browsers are made for calls: they need more for the same.
 */
const BITS: Record<VideoQuality, { avc: number; others: number }> = {
  low: { avc: 0.35, others: 0.06 },
  medium: { avc: 0.5, others: 0.12 },
  high: { avc: 0.75, others: 0.24 },
  'very-high': { avc: 1.2, others: 0.48 },
};

/** Bits for each pixel of each frame that videos of cameras took. */
const USUAL: Record<VideoQuality, number> = { low: 0.16, medium: 0.2, high: 0.26, 'very-high': 0.36 };

/** Of that, what objects cut out take, alpha and all. */
const CUTOUT = 0.4;

/** Small pictures need more for each of their pixels. */
const LEAST_BITRATE = 500_000;

/** Returns the bitrate, in bits per second. */
export function bitrateOf(
  quality: VideoQuality,
  codec: Codec,
  { width, height, frameRate }: { width: number; height: number; frameRate: number },
): number {
  const bits = BITS[quality][codec === 'avc' ? 'avc' : 'others'];
  return Math.max(LEAST_BITRATE, Math.round(bits * width * height * frameRate));
}

/** What is known of a video before it is made. */
export interface VideoEstimate {
  /** In pixels. */
  width: number;
  height: number;
  numFrames: number;
  /** `overlay` if not given. */
  style?: 'overlay' | 'cutout' | 'masks' | 'alpha';
  /** `high` if not given. */
  quality?: VideoQuality;
}

/**
 * About how large a file `encodeVideo` makes, in bytes. What is in the picture decides, so it may be three times as much
 * or a third.
 */
export function estimateVideoSize(video: VideoEstimate): number {
  const legal = ['width', 'height', 'numFrames', 'style', 'quality'];
  const { width, height, numFrames, style = 'overlay', quality = 'high' } = checkedOptions(video, legal);
  wholeNumber('param', 'width', width, 1, 16384);
  wholeNumber('param', 'height', height, 1, 16384);
  checkNumber('numFrames', numFrames, 1, 10_000_000);
  if (!QUALITIES.includes(quality))
    throw illegal('param', 'quality', quality, QUALITIES.map((word) => `'${word}'`).join(', '));
  if (!['overlay', 'cutout', 'masks', 'alpha'].includes(style))
    throw illegal('param', 'style', style, "'overlay', 'cutout', 'masks', 'alpha'");
  const part = style === 'overlay' ? 1 : CUTOUT;
  return Math.round((part * USUAL[quality] * width * height * numFrames) / 8);
}
