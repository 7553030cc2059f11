// Plays the original clip: one frame, or a part in a loop.

import { type Source, endTime, frameTime } from '../model/source.js';
import { h } from './dom.js';

/** Long side of frames that the page plays itself, in pixels; chosen by eye. */
const PLAYER_SIDE_PX = 480;

/** Added to the time of a frame when seeking, in seconds, as players round. */
const SEEK_OFFSET_S = 0.002;

export interface ClipPlayer {
  element: HTMLElement;
  show: (frame: number) => void;
  play: (first: number, last: number, onFrame: (frame: number) => void) => void;
  pause: () => void;
  mute: (isMuted: boolean) => void;
  close: () => void;
}

export function openPlayer(source: Source): ClipPlayer {
  if (source.kind !== 'video' || !source.file || !plays(source.type)) return new FramePlayer(source);
  return new VideoPlayer(source, source.file);
}

/** Returns whether the browser may play a file. Its answer is reliable only for transport streams. */
function plays(type?: string) {
  return type !== 'video/mp2t' || document.createElement('video').canPlayType(type) !== '';
}

/** Uses the browser's video player, which is fast enough for large videos. */
class VideoPlayer implements ClipPlayer {
  element = h('video', { playsinline: true, preload: 'auto', 'aria-label': 'Original clip' });
  ticking: number;

  constructor(
    public source: Source,
    file: File,
  ) {
    this.element.src = URL.createObjectURL(file);
    this.ticking = 0;
  }

  show(frame: number) {
    this.pause();
    this.element.currentTime = frameTime(this.source, frame) + SEEK_OFFSET_S;
  }

  play(first: number, last: number, onFrame: (frame: number) => void) {
    this.pause();
    const { source, element } = this;
    const from = frameTime(source, first) + SEEK_OFFSET_S;
    const to = last + 1 < source.count ? frameTime(source, last + 1) : endTime(source);
    if (element.currentTime < from || element.currentTime >= to) element.currentTime = from;
    const tick = () => {
      this.ticking = requestAnimationFrame(tick);
      if (element.currentTime >= to || element.ended) {
        element.currentTime = from;
        element.play().catch(() => {});
      }
      onFrame(findFrame(source, element.currentTime));
    };
    this.ticking = requestAnimationFrame(tick);
    element.play().catch(() => {});
  }

  pause() {
    cancelAnimationFrame(this.ticking);
    this.element.pause();
  }

  mute(isMuted: boolean) {
    this.element.muted = isMuted;
  }

  close() {
    this.pause();
    closeMedia(this.element);
  }
}

/** Lets go of the file that an element plays. */
export function closeMedia(element: HTMLMediaElement) {
  const { src } = element;
  element.pause();
  element.removeAttribute('src');
  element.load();
  URL.revokeObjectURL(src);
}

/** Plays frames that the page reads, for images. */
class FramePlayer implements ClipPlayer {
  element = h('canvas', { role: 'img', 'aria-label': 'Original clip' });
  ctx: CanvasRenderingContext2D | null;
  /** Stops playback and voids pending frames. */
  going = new AbortController();

  constructor(public source: Source) {
    this.ctx = this.element.getContext('2d');
  }

  async show(frame: number) {
    this.pause();
    const { signal } = this.going;
    const image = await this.source.preview(frame, PLAYER_SIDE_PX).catch(() => null);
    if (image && !signal.aborted) this.draw(image);
  }

  async play(first: number, last: number, onFrame: (frame: number) => void) {
    this.pause();
    const { signal } = this.going;
    const { source } = this;
    try {
      while (!signal.aborted) {
        let at = first;
        const trim = { start: first, frames: last - first + 1, step: 1, side: PLAYER_SIDE_PX };
        for await (const { frame } of source.frames(trim, signal)) {
          if (signal.aborted) return;
          this.draw(frame);
          onFrame(at);
          const duration =
            (at + 1 < source.count ? frameTime(source, at + 1) : endTime(source)) - frameTime(source, at);
          await new Promise((resolve) => setTimeout(resolve, 1000 * duration));
          at += 1;
        }
      }
    } catch {
      // Paused, or a damaged frame, which the run reports.
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

  /** Images are silent. */
  mute() {}

  close() {
    this.going.abort();
  }
}

/** @param time in seconds */
function findFrame({ times, fps, count }: Source, time: number) {
  if (!times) return Math.min(count - 1, Math.floor(time * fps));
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}
