// The clip itself, without a run: one frame of it, or a part that plays round and round.

import { type Source, endOf, timeOf } from '../model/source.js';
import { h } from './dom.js';

/** Long side at which frames that no player shows are read, in pixels. */
const SIDE = 480;

/** A frame is looked for a little after it begins: players round, in seconds. */
const LATE = 0.002;

export interface ClipPlayer {
  element: HTMLElement;
  show: (frame: number) => void;
  play: (first: number, last: number, onFrame: (frame: number) => void) => void;
  pause: () => void;
  close: () => void;
}

export function openPlayer(source: Source): ClipPlayer {
  if (source.kind !== 'video' || !source.file || !plays(source.type)) return new FramePlayer(source);
  return new VideoPlayer(source, source.file);
}

/** Few browsers play transport streams, and they say so; of other files they do not say what they play. */
function plays(type?: string) {
  return type !== 'video/mp2t' || document.createElement('video').canPlayType(type) !== '';
}

/** The browser's own player: it keeps up with large videos. */
class VideoPlayer implements ClipPlayer {
  url: string;
  element = h('video', { playsinline: true, preload: 'auto', 'aria-label': 'The clip as it is' });
  ticking: number;

  constructor(
    public source: Source,
    file: File,
  ) {
    this.url = URL.createObjectURL(file);
    this.element.muted = true;
    this.element.src = this.url;
    this.ticking = 0;
  }

  show(frame: number) {
    this.pause();
    this.element.currentTime = timeOf(this.source, frame) + LATE;
  }

  play(first: number, last: number, onFrame: (frame: number) => void) {
    this.pause();
    const { source, element } = this;
    const from = timeOf(source, first) + LATE;
    const to = last + 1 < source.count ? timeOf(source, last + 1) : endOf(source);
    if (element.currentTime < from || element.currentTime >= to) element.currentTime = from;
    const tick = () => {
      this.ticking = requestAnimationFrame(tick);
      if (element.currentTime >= to || element.ended) {
        element.currentTime = from;
        element.play().catch(() => {});
      }
      onFrame(frameAt(source, element.currentTime));
    };
    this.ticking = requestAnimationFrame(tick);
    element.play().catch(() => {});
  }

  pause() {
    cancelAnimationFrame(this.ticking);
    this.element.pause();
  }

  close() {
    this.pause();
    this.element.removeAttribute('src');
    this.element.load();
    URL.revokeObjectURL(this.url);
  }
}

/** Frames as the page reads them, for images. */
class FramePlayer implements ClipPlayer {
  element = h('canvas', { role: 'img', 'aria-label': 'The clip as it is' });
  ctx: CanvasRenderingContext2D | null;
  /** Ends what is shown or played; what was awaited before is void. */
  going = new AbortController();

  constructor(public source: Source) {
    this.ctx = this.element.getContext('2d');
  }

  async show(frame: number) {
    this.pause();
    const { signal } = this.going;
    const image = await this.source.preview(frame, SIDE).catch(() => null);
    if (image && !signal.aborted) this.draw(image);
  }

  async play(first: number, last: number, onFrame: (frame: number) => void) {
    this.pause();
    const { signal } = this.going;
    const { source } = this;
    try {
      while (!signal.aborted) {
        let at = first;
        const take = { start: first, frames: last - first + 1, step: 1, side: SIDE };
        for await (const { frame } of source.frames(take, signal)) {
          if (signal.aborted) return;
          this.draw(frame);
          onFrame(at);
          const lasts = (at + 1 < source.count ? timeOf(source, at + 1) : endOf(source)) - timeOf(source, at);
          await new Promise((resolve) => setTimeout(resolve, 1000 * lasts));
          at += 1;
        }
      }
    } catch {
      // Paused, or a frame is damaged: the run says so.
    }
  }

  draw(image: ImageData) {
    const { element } = this;
    if (element.width !== image.width || element.height !== image.height)
      Object.assign(element, { width: image.width, height: image.height });
    this.ctx?.putImageData(image, 0, 0);
  }

  pause() {
    this.going.abort();
    this.going = new AbortController();
  }

  close() {
    this.going.abort();
  }
}

/** @param time in seconds */
function frameAt({ times, fps, count }: Source, time: number) {
  if (!times) return Math.min(count - 1, Math.floor(time * fps));
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}
