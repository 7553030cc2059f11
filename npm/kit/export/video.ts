// Masks and frames as a video file, encoded by the browser.

import {
  TraceCutError,
  checkFlag,
  checkNumber,
  checkedOptions,
  illegal,
  isIterable,
  oneOf,
} from '../../check/errors.js';
import { type MaskSource, type ObjectChoice, checkMasks, chosenLabels, endOf, timesOf } from '../../check/masks.js';
import { GROUNDS, type Ground, isGround } from '../../draw/cutout.js';
import { type LabelColors, SCREEN_GREEN } from '../../draw/palette.js';
import { type MaskEdges, checkedEdges } from '../edit/adjust.js';
import { ahead } from '../edit/ahead.js';
import { tooFew } from '../edit/at-size.js';
import { breath } from '../../worker/pause.js';
import { QUALITIES, type VideoQuality } from './quality.js';
import { type SoundOptions, checkedSound } from './sound.js';
import type { WasmSource } from '../../check/options.js';
import type { PixelFrame } from '../../worker/frames.js';
import type { ExportProgress } from './masks.js';
import type { VideoFile } from './video-file.js';

/**
 * A frame to encode: anything a canvas can draw, pixels, the bytes of an image file, or an object with one of these as
 * its `frame`, as `videoFrames` gives them.
 */
export type EncodeFrame = CanvasImageSource | PixelFrame | Blob;

/** The frames of a clip, one for each frame of the masks, in order. */
export type EncodeFrames = Iterable<EncodeItem> | AsyncIterable<EncodeItem>;

export type EncodeItem = EncodeFrame | { frame: EncodeFrame };

export interface EncodeVideoOptions {
  /**
   * `overlay`, the frames with the masks drawn over them, if not given; `cutout`, the objects alone; `masks`, the
   * masks' colours on black, without frames; `alpha`, how opaque the objects are, white on black: a matte for
   * editors, of the frames' size where frames are given.
   */
  style?: 'overlay' | 'cutout' | 'masks' | 'alpha';
  /** `webm` if not given. */
  format?: 'webm' | 'mp4';
  /**
   * Of cut-out objects: `transparent` (WebM only, and its default), `blurred`, `desaturated`, `dimmed`, any CSS
   * colour (`#00b140`, the green of screens, in MP4 if not given), or a picture.
   */
  background?: Ground;
  /** All but the background if not given. */
  objects?: ObjectChoice;
  /**
   * Of the masks in overlays, cut-outs and mattes: specks left out, objects grown or shrunk, cut-outs with soft edges.
   */
  edges?: MaskEdges;
  /** Of the masks; `objectColor` if not given. */
  colors?: LabelColors;
  /** Of the masks' fill in an overlay, 0 to 1; 0.5 if not given. */
  opacity?: number;
  /** Of the masks in an overlay as a whole, fill and outline, 0 to 1; 1 if not given. */
  maskOpacity?: number;
  /** Of the masks in an overlay; true if not given. */
  outline?: boolean;
  /** In pixels of the video; 2 if not given. */
  outlineWidth?: number;
  /** Frames per second, where the masks have no times; 25 if not given. */
  frameRate?: number;
  /** `high` if not given. */
  quality?: VideoQuality;
  /**
   * Kept in the video: packet by packet where the format can hold it as it is, converted to Opus where not; none if
   * not given. Whether this browser can do it, `soundInfo` says.
   */
  sound?: SoundOptions;
  /** As for a session, where masks are smaller than the frames. */
  decoder?: WasmSource;
  /** Told of each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Ends the work: the promise rejects with its reason. */
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

const FRAME_RATE = 25;

/**
 * Encodes masks and frames as a video with the masks' own times (the first frame is at 0). The video has the frames'
 * size, and masks that are smaller are enlarged by the frames (`enlargeMask`); MP4 wants even numbers, so an odd side
 * gets one more row or column, a copy of the last. Frames are neither kept nor closed.
 * @param frames null for the style `masks`, which needs none
 */
export async function encodeVideo(
  masks: MaskSource,
  frames: EncodeFrames | null,
  options: EncodeVideoOptions = {},
): Promise<Blob> {
  checkMasks(masks);
  const plan = planned(masks, frames, checkedOptions(options, LEGAL));
  if (typeof VideoEncoder === 'undefined' || typeof OffscreenCanvas === 'undefined') {
    throw new TraceCutError(
      'unsupported',
      'encodeVideo needs WebCodecs and OffscreenCanvas, which this engine does not have; masksZip gives the masks as PNG files',
    );
  }
  const { onProgress, signal } = options;
  // Loaded when a video is made: few pages make any.
  const [{ openFile }, { Painter }] = await Promise.all([import('./video-file.js'), import('./video-painter.js')]);
  let file: VideoFile | null = null;
  const painter = new Painter(masks, plan);
  let t = 0;
  try {
    const items: Iterable<EncodeItem | null> | AsyncIterable<EncodeItem | null> =
      frames && plan.style !== 'masks' ? frames : blanks(masks.numFrames);
    const take = (item: EncodeItem | null, at: number) => {
      signal?.throwIfAborted();
      return painter.take(item, at);
    };
    for await (const { picture, mask } of ahead(items, masks.numFrames, take)) {
      signal?.throwIfAborted();
      painter.paint(picture, mask, t);
      file ??= await openFile(painter, plan);
      const { time, duration } = plan.timing(t);
      await file.add(time, duration);
      t += 1;
      onProgress?.({ done: t, total: masks.numFrames });
    }
    if (t < masks.numFrames) throw tooFew(t, masks.numFrames);
    signal?.throwIfAborted();
    return await file!.finish();
  } catch (error) {
    await file?.cancel();
    throw error;
  }
}

async function* blanks(count: number) {
  for (let t = 0; t < count; t += 1) {
    await breath();
    yield null;
  }
}

export type Plan = ReturnType<typeof planned>;

function planned(masks: MaskSource, frames: EncodeFrames | null, options: EncodeVideoOptions) {
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
  oneOf('style', style, STYLES);
  oneOf('format', format, ['webm', 'mp4']);
  oneOf('quality', quality, QUALITIES);
  checkNumber('opacity', opacity, 0, 1);
  checkNumber('maskOpacity', maskOpacity, 0, 1);
  checkNumber('outlineWidth', outlineWidth, 0, 1000);
  checkFlag('outline', outline);
  const { background = format === 'webm' ? 'transparent' : SCREEN_GREEN } = options;
  if (!isGround(background)) throw illegal('param', 'background', background, GROUNDS);
  const alpha = style === 'cutout' && background === 'transparent';
  if (alpha && format === 'mp4')
    throw illegal('param', 'background', background, "a colour: MP4 files cannot be transparent, format: 'webm' can");
  const isAlone = style === 'masks' || (style === 'alpha' && frames === null);
  if (!isAlone && !isIterable(frames))
    throw illegal('param', 'frames', frames, 'an iterable of the frames, one for each frame of the masks');
  const frameRate = options.frameRate ?? FRAME_RATE;
  const times = (timesOf(masks, options.frameRate) ?? timesOf(masks, FRAME_RATE))!;
  return {
    style,
    format,
    quality,
    background,
    alpha,
    chosen: chosenLabels(objects),
    labels: { colors, opacity, outline },
    outlineWidth,
    maskOpacity,
    edges: checkedEdges(options.edges),
    decoder: options.decoder,
    sound: checkedSound(options.sound),
    frameRate: rateOf(times, frameRate),
    timing: timing(times, endOf(masks, times, frameRate)),
  };
}

/**
 * @param frameRate of a single frame
 * @returns frames per second in the mean
 */
function rateOf(times: Float64Array, frameRate: number): number {
  const last = times.length - 1;
  return last > 0 ? last / (Number(times[last]) - Number(times[0])) : frameRate;
}

/**
 * When a frame is shown and for how long, counted from the first.
 * @param end of the last
 * @returns in seconds
 */
export function timing(times: Float64Array, end: number): (t: number) => { time: number; duration: number } {
  const first = Number(times[0]);
  return (t) => ({ time: Number(times[t]) - first, duration: Number(times[t + 1] ?? end) - Number(times[t]) });
}
