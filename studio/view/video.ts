// Sources of frames from video files, and reading of canvas pixels.

import { fitSize, videoFrames, videoInfo, videoStrip } from '../model/library.js';
import { PageError } from '../model/messages.js';
import type { Damage, PixelFrame, VideoInfo } from '../model/library.js';
import type { Source, Trim } from '../model/source.js';

/** Reads pixels of images that the browser can draw. */
export class Grabber {
  canvas = new OffscreenCanvas(1, 1);
  ctx: OffscreenCanvasRenderingContext2D;

  constructor() {
    this.ctx = this.canvas.getContext('2d', { willReadFrequently: true, alpha: false })!;
  }

  /**
   * @param size of the picture in pixels
   * @param side long side of the result
   */
  grab(picture: CanvasImageSource, size: { width: number; height: number }, side: number): ImageData {
    const { width, height } = fitSize(size, side);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.ctx.imageSmoothingQuality = 'high';
    this.ctx.drawImage(picture, 0, 0, width, height);
    return this.ctx.getImageData(0, 0, width, height);
  }
}

/** Returns whether the browser adds noise to canvas pixels against fingerprinting, so that results vary slightly. */
export function addsCanvasNoise(): boolean {
  const side = 32;
  const canvas = new OffscreenCanvas(side, side);
  const ctx = canvas.getContext('2d', { willReadFrequently: true })!;
  ctx.fillStyle = 'rgb(120, 130, 140)';
  ctx.fillRect(0, 0, side, side);
  const { data } = ctx.getImageData(0, 0, side, side);
  return data.some((byte, k) => byte !== [120, 130, 140, 255][k % 4]);
}

/** Frame rate of files that state none. */
const DEFAULT_FPS = 30;

/** Subtracted from the time of a frame when seeking, in seconds, as times are rounded. */
const SEEK_MARGIN_S = 1e-4;

interface VideoFacts {
  info: VideoInfo;
  fps: number;
  count: number;
  /** True if the file ends early. */
  isDamaged: boolean;
}

export async function readVideoFacts(file: File): Promise<VideoFacts> {
  let isDamaged = false;
  const info = await videoInfo(file, { onDamage: () => void (isDamaged = true) });
  const fps = info.frameRate > 0 ? info.frameRate : DEFAULT_FPS;
  return { info, fps, count: Math.max(1, info.numFrames ?? Math.round(info.duration * fps)), isDamaged };
}

/**
 * Opens a video or an animated image.
 * @param facts if known already
 */
export async function openVideo(file: File, kind: 'video' | 'images' = 'video', facts?: VideoFacts): Promise<Source> {
  const { info, fps, count, isDamaged } = facts ?? (await understood(() => readVideoFacts(file), file.name));
  const early = (time: number) => ({ start: Math.max(0, time - SEEK_MARGIN_S) });
  /** Returns options that start at a frame: at its time if known, else half a frame early. */
  const startOf = (frame: number) => {
    const time = info.times?.[frame];
    if (frame === 0) return {};
    return time === undefined ? { start: (frame - 0.5) / fps } : early(time);
  };
  const direct = ({ start, step, frames: maxFrames, side }: Trim) => {
    source.damage = isDamaged && start + maxFrames * step >= count ? { total: null, frames: maxFrames } : null;
    const onDamage = (damage: Damage) => (source.damage = damage);
    return { source: file, options: { ...startOf(start), step, maxFrames, size: side, onDamage } };
  };
  const source: Source = {
    kind,
    name: file.name,
    width: info.width,
    height: info.height,
    fps,
    count,
    file,
    times: info.times,
    end: (info.times?.[0] ?? 0) + info.duration,
    async *strip(most, side, signal) {
      const options = { count: most, size: side, signal, onDamage() {} };
      for await (const frame of videoStrip(file, options)) yield pixelsOf(await frame.pixels());
    },
    async preview(frame, side, time) {
      const start = time === undefined ? startOf(frame) : early(time);
      const frames = videoFrames(file, { ...start, maxFrames: 1, size: side, onDamage() {} });
      for await (const decoded of frames) return pixelsOf(await decoded.pixels());
      throw new PageError('no-frames', file.name);
    },
    direct,
    pictures: (trim, signal) => videoFrames(file, { ...direct(trim).options, signal }),
    async *frames(trim, signal) {
      const { options } = direct(trim);
      for await (const frame of videoFrames(file, { ...options, signal })) {
        const end = trim.step === 1 && frame.duration > 0 ? frame.time + frame.duration : null;
        yield { frame: pixelsOf(await frame.pixels()), time: frame.time, end };
      }
    },
    close() {},
  };
  // Decodes one frame to test the decoder.
  await understood(() => source.preview(0, 32), file.name);
  return source;
}

const pixelsOf = (frame: PixelFrame) => frame as ImageData;

async function understood<T>(ask: () => Promise<T>, name: string): Promise<T> {
  try {
    return await ask();
  } catch (error) {
    if ((error as { code?: unknown })?.code === 'codec') throw error;
    throw new PageError('unreadable-video', `${name}: ${error instanceof Error ? error.message : String(error)}`);
  }
}
