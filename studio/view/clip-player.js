/** The clip itself, without a run: one frame of it, or a part that plays round and round. @module */

import { endOf, timeOf } from '../model/source.js';
import { h } from './dom.js';

/** @typedef {import('../model/source.js').Source} Source */

/** Long side at which frames that no player shows are read, in pixels. */
const SIDE = 480;

/** A frame is looked for a little after it begins: players round, in seconds. */
const LATE = 0.002;

/**
 * @typedef {object} ClipPlayer
 * @property {HTMLElement} element
 * @property {(frame: number) => void} show
 * @property {(first: number, last: number, onFrame: (frame: number) => void) => void} play
 * @property {() => void} pause
 * @property {() => void} close
 */

/**
 * @param {Source} source
 * @returns {ClipPlayer}
 */
export function openPlayer(source) {
  if (source.kind !== 'video' || !source.file || !plays(source.type)) return new FramePlayer(source);
  return new VideoPlayer(source, source.file);
}

/**
 * Few browsers play transport streams, and they say so; of other files they do not say what they play.
 *
 * @param {string} [type]
 */
function plays(type) {
  return type !== 'video/mp2t' || document.createElement('video').canPlayType(type) !== '';
}

/** The browser's own player: it keeps up with large videos. @implements {ClipPlayer} */
class VideoPlayer {
  /**
   * @param {Source} source
   * @param {File} file
   */
  constructor(source, file) {
    this.source = source;
    this.url = URL.createObjectURL(file);
    this.element = h('video', { playsinline: true, preload: 'auto', 'aria-label': 'The clip as it is' });
    this.element.muted = true;
    this.element.src = this.url;
    this.ticking = 0;
  }

  /** @param {number} frame */
  show(frame) {
    this.pause();
    this.element.currentTime = timeOf(this.source, frame) + LATE;
  }

  /**
   * @param {number} first
   * @param {number} last
   * @param {(frame: number) => void} onFrame
   */
  play(first, last, onFrame) {
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

/** Frames as the page reads them, for images. @implements {ClipPlayer} */
class FramePlayer {
  /** @param {Source} source */
  constructor(source) {
    this.source = source;
    this.element = h('canvas', { role: 'img', 'aria-label': 'The clip as it is' });
    this.ctx = this.element.getContext('2d');
    /** Ends what is shown or played; what was awaited before is void. */
    this.going = new AbortController();
  }

  /** @param {number} frame */
  async show(frame) {
    this.pause();
    const { signal } = this.going;
    const image = await this.source.preview(frame, SIDE).catch(() => null);
    if (image && !signal.aborted) this.draw(image);
  }

  /**
   * @param {number} first
   * @param {number} last
   * @param {(frame: number) => void} onFrame
   */
  async play(first, last, onFrame) {
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

  /** @param {ImageData} image */
  draw(image) {
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

/**
 * @param {Source} source
 * @param {number} time in seconds
 */
function frameAt({ times, fps, count }, time) {
  if (!times) return Math.min(count - 1, Math.floor(time * fps));
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}
