// A video file as a source of frames, each with its own time; pixels of whatever the browser can draw.

import { fitSize, videoFrames, videoInfo, videoStrip } from '../model/library.js';
import { PageError } from '../model/words.js';
import type { Damage, PixelFrame, VideoInfo } from '../model/library.js';
import type { Source, Take } from '../model/source.js';

/** Reads pixels of whatever the browser can draw. */
export class Grabber {
  canvas = new OffscreenCanvas(1, 1);
  ctx: OffscreenCanvasRenderingContext2D;

  constructor() {
    this.ctx = this.canvas.getContext('2d', { willReadFrequently: true, alpha: false })!;
  }

  /**
   * @param size the picture's own size in pixels
   * @param side longest side of the answer
   */
  grab(picture: CanvasImageSource, size: { width: number; height: number }, side: number): ImageData {
    const { width, height } = fitSize(size, side);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.ctx.imageSmoothingQuality = 'high';
    this.ctx.drawImage(picture, 0, 0, width, height);
    return this.ctx.getImageData(0, 0, width, height);
  }
}

/**
 * Some browsers add noise to what a page reads from a canvas, against fingerprinting. Then the same clip gives other
 * bytes each time, and results differ a little.
 */
export function readsAreNoisy(): boolean {
  const side = 32;
  const canvas = new OffscreenCanvas(side, side);
  const ctx = canvas.getContext('2d', { willReadFrequently: true })!;
  ctx.fillStyle = 'rgb(120, 130, 140)';
  ctx.fillRect(0, 0, side, side);
  const { data } = ctx.getImageData(0, 0, side, side);
  return data.some((byte, k) => byte !== [120, 130, 140, 255][k % 4]);
}

/** Taken where the file does not tell. */
const USUAL_FPS = 30;

/** Times are rounded: a frame is looked for from so much before its time on, in seconds. */
const EARLY = 1e-4;

interface Facts {
  info: VideoInfo;
  fps: number;
  count: number;
  /** It ends with its last frame, but there was more. */
  isDamaged: boolean;
}

export async function factsOf(file: File): Promise<Facts> {
  let isDamaged = false;
  const info = await videoInfo(file, { onDamage: () => void (isDamaged = true) });
  const fps = info.frameRate > 0 ? info.frameRate : USUAL_FPS;
  return { info, fps, count: Math.max(1, info.numFrames ?? Math.round(info.duration * fps)), isDamaged };
}

/**
 * @param kind what it is called: an animated image holds images
 * @param facts where they are known
 */
export async function openVideo(file: File, kind: 'video' | 'images' = 'video', facts?: Facts): Promise<Source> {
  const { info, fps, count, isDamaged } = facts ?? (await understood(() => factsOf(file), file.name));
  const early = (time: number) => ({ start: Math.max(0, time - EARLY) });
  /** By its time where the file says it; else half a frame early. */
  const startOf = (frame: number) => {
    const time = info.times?.[frame];
    if (frame === 0) return {};
    return time === undefined ? { start: (frame - 0.5) / fps } : early(time);
  };
  const direct = ({ start, step, frames: maxFrames, side }: Take) => {
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
      for await (const one of videoStrip(file, options)) yield pixelsOf(await one.pixels());
    },
    async preview(frame, side, time) {
      const start = time === undefined ? startOf(frame) : early(time);
      const frames = videoFrames(file, { ...start, maxFrames: 1, size: side, onDamage() {} });
      for await (const one of frames) return pixelsOf(await one.pixels());
      throw new PageError('no-frames', file.name);
    },
    direct,
    async *frames(take, signal) {
      const { options } = direct(take);
      for await (const one of videoFrames(file, { ...options, signal })) {
        const end = take.step === 1 && one.duration > 0 ? one.time + one.duration : null;
        yield { frame: pixelsOf(await one.pixels()), time: one.time, end };
      }
    },
    close() {},
  };
  // Whether it can be decoded is not known before one frame has been.
  await understood(() => source.preview(0, 32), file.name);
  return source;
}

/** As the package gives them in browsers. */
const pixelsOf = (frame: PixelFrame) => frame as ImageData;

async function understood<T>(ask: () => Promise<T>, name: string): Promise<T> {
  try {
    return await ask();
  } catch (error) {
    if ((error as { code?: unknown })?.code === 'codec') throw error;
    throw new PageError('unreadable-video', `${name}: ${error instanceof Error ? error.message : String(error)}`);
  }
}
