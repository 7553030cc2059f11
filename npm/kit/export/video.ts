// Encodes masks and frames as a video file in the browser.

import {
  TraceCutError,
  checkChoice,
  checkFlag,
  checkNumber,
  checkOptions,
  illegal,
  isIterable,
} from '../../check/errors.js';
import { type MaskSource, type ObjectChoice, checkMasks, getEnd, getTimes, selectLabels } from '../../check/masks.js';
import { type Backdrop, LEGAL_BACKDROPS, isBackdrop } from '../../draw/cutout.js';
import { type LabelColors, SCREEN_GREEN } from '../../draw/labels.js';
import { type MaskEdges, checkEdges } from '../edit/adjust.js';
import { createTooFewError, prefetch } from '../edit/at-size.js';
import { yieldThread } from '../../worker/pause.js';
import { QUALITIES, type SoundOptions, type VideoQuality, checkSound } from './video-options.js';
import type { WasmSource } from '../../check/options.js';
import type { PixelFrame } from '../../worker/frames.js';
import type { ExportProgress } from './masks.js';
import type { VideoFile } from './video-file.js';

/**
 * A frame to encode: anything a canvas can draw, pixels, the bytes of an image file, or an object with one of these as
 * its `frame`, as `videoFrames` yields them.
 */
export type EncodeFrame = CanvasImageSource | PixelFrame | Blob;

/** The frames of a clip, one for each frame of the masks, in order. */
export type EncodeFrames = Iterable<EncodeItem> | AsyncIterable<EncodeItem>;

export type EncodeItem = EncodeFrame | { frame: EncodeFrame };

/** Options of `encodeVideo`. */
export interface EncodeVideoOptions {
  /**
   * `overlay`, the frames with the masks drawn over them, if not given; `cutout`, the objects alone; `masks`, the
   * masks' colours on black, without frames; `alpha`, the opacity of the objects, white on black: a matte for editors, of
   * the frames' size if there are frames.
   */
  style?: 'overlay' | 'cutout' | 'masks' | 'alpha';
  /** File format; `webm` if not given. */
  format?: 'webm' | 'mp4';
  /**
   * Backdrop of cut-out objects: `transparent` (WebM only, and its default), `blurred`, `desaturated`, `dimmed`, any CSS
   * colour (in MP4 `#00b140`, green-screen green, if not given), or a picture.
   */
  background?: Backdrop;
  /** Objects to show; all but the background if not given. */
  objects?: ObjectChoice;
  /** Adjusts the masks of overlays, cut-outs and mattes: removes specks, grows or shrinks objects, softens cut-outs. */
  edges?: MaskEdges;
  /** Colours of the masks; `objectColor` if not given. */
  colors?: LabelColors;
  /** Opacity of the masks' fill in an overlay, 0 to 1; 0.5 if not given. */
  opacity?: number;
  /** Opacity of a mask as a whole in an overlay, fill and outline, 0 to 1; 1 if not given. */
  maskOpacity?: number;
  /** Draws outlines in an overlay; true if not given. */
  outline?: boolean;
  /** Width in pixels of the video; 2 if not given. */
  outlineWidth?: number;
  /** Frames per second, if the masks have no times; 25 if not given. */
  frameRate?: number;
  /** Encoding quality; `high` if not given. */
  quality?: VideoQuality;
  /**
   * Sound of the video: copied packet by packet if the format can hold it, else converted to Opus; none if not given.
   * `soundInfo` tells if this browser can do it.
   */
  sound?: SoundOptions;
  /** As for a session; needed if masks are smaller than the frames. */
  decoder?: WasmSource;
  /** Called for each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
}

const LEGAL = [
  'style',
  'format',
  'background',
  'objects',
  'colors',
  'edges',
  'opacity',
  'maskOpacity',
  'outline',
  'outlineWidth',
  'frameRate',
  'quality',
  'sound',
  'decoder',
  'onProgress',
  'signal',
];

const STYLES = ['overlay', 'cutout', 'masks', 'alpha'] as const;

/** Frames per second of masks without times. */
const DEFAULT_FRAME_RATE = 25;

/**
 * Encodes masks and frames as a video with the masks' own times (the first frame is at 0). The video has the frames'
 * size, and smaller masks are enlarged (`enlargeMask`). MP4 requires even sizes, so an odd side gets one more row or
 * column, a copy of the last. Frames are neither kept nor closed.
 * @param frames null for the style `masks`, which needs none
 */
export async function encodeVideo(
  masks: MaskSource,
  frames: EncodeFrames | null,
  options: EncodeVideoOptions = {},
): Promise<Blob> {
  checkMasks(masks);
  const plan = planVideo(masks, frames, checkOptions(options, LEGAL));
  if (typeof VideoEncoder === 'undefined' || typeof OffscreenCanvas === 'undefined') {
    throw new TraceCutError(
      'unsupported',
      'encodeVideo needs WebCodecs and OffscreenCanvas, which this engine lacks; masksZip saves the masks as PNG files',
    );
  }
  const { onProgress, signal } = options;
  // Loaded on use, as few pages encode videos.
  const [{ openVideoFile }, { Painter }] = await Promise.all([import('./video-file.js'), import('./video-painter.js')]);
  let file: VideoFile | null = null;
  const painter = new Painter(masks, plan);
  let t = 0;
  try {
    const items: Iterable<EncodeItem | null> | AsyncIterable<EncodeItem | null> =
      frames && plan.style !== 'masks' ? frames : createBlanks(masks.numFrames);
    const take = (item: EncodeItem | null, index: number) => {
      signal?.throwIfAborted();
      return painter.take(item, index);
    };
    for await (const { picture, mask } of prefetch(items, masks.numFrames, take)) {
      signal?.throwIfAborted();
      painter.paint(picture, mask, t);
      file ??= await openVideoFile(painter, plan);
      const { time, duration } = plan.timing(t);
      await file.add(time, duration);
      t += 1;
      onProgress?.({ done: t, total: masks.numFrames });
    }
    if (t < masks.numFrames) throw createTooFewError(t, masks.numFrames);
    signal?.throwIfAborted();
    return await file!.finish();
  } catch (error) {
    await file?.cancel();
    throw error;
  }
}

async function* createBlanks(count: number) {
  for (let t = 0; t < count; t += 1) {
    await yieldThread();
    yield null;
  }
}

export type VideoPlan = ReturnType<typeof planVideo>;

function planVideo(masks: MaskSource, frames: EncodeFrames | null, options: EncodeVideoOptions) {
  const {
    style = 'overlay',
    format = 'webm',
    quality = 'high',
    objects,
    colors,
    opacity = 0.5,
    maskOpacity = 1,
    outline = true,
    outlineWidth = 2,
  } = options;
  checkChoice('style', style, STYLES);
  checkChoice('format', format, ['webm', 'mp4']);
  checkChoice('quality', quality, QUALITIES);
  checkNumber('opacity', opacity, 0, 1);
  checkNumber('maskOpacity', maskOpacity, 0, 1);
  checkNumber('outlineWidth', outlineWidth, 0, 1000);
  checkFlag('outline', outline);
  const { background = format === 'webm' ? 'transparent' : SCREEN_GREEN } = options;
  if (!isBackdrop(background)) throw illegal('param', 'background', background, LEGAL_BACKDROPS);
  const alpha = style === 'cutout' && background === 'transparent';
  if (alpha && format === 'mp4')
    throw illegal('param', 'background', background, "a colour: MP4 files cannot be transparent, format: 'webm' can");
  const needsNoFrames = style === 'masks' || (style === 'alpha' && frames === null);
  if (!needsNoFrames && !isIterable(frames))
    throw illegal('param', 'frames', frames, 'an iterable of the frames, one for each frame of the masks');
  const frameRate = options.frameRate ?? DEFAULT_FRAME_RATE;
  const times = (getTimes(masks, options.frameRate) ?? getTimes(masks, DEFAULT_FRAME_RATE))!;
  return {
    style,
    format,
    quality,
    background,
    alpha,
    selected: selectLabels(objects),
    labels: { colors, opacity, outline },
    outlineWidth,
    maskOpacity,
    edges: checkEdges(options.edges),
    decoder: options.decoder,
    sound: checkSound(options.sound),
    frameRate: computeRate(times, frameRate),
    timing: createTiming(times, getEnd(masks, times, frameRate)),
  };
}

/**
 * Computes the average frame rate, in frames per second.
 * @param frameRate of a single frame
 */
function computeRate(times: Float64Array, frameRate: number): number {
  const last = times.length - 1;
  return last > 0 ? last / (Number(times[last]) - Number(times[0])) : frameRate;
}

/**
 * Returns a function from frame to time, counted from the first frame, and duration, both in seconds.
 * @param end of the last frame
 */
export function createTiming(times: Float64Array, end: number): (t: number) => { time: number; duration: number } {
  const first = Number(times[0]);
  return (t) => ({ time: Number(times[t]) - first, duration: Number(times[t + 1] ?? end) - Number(times[t]) });
}
