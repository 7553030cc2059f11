// Caches of frame data and pictures for layers.

import type { FrameData } from '../../model/frame-data.js';
import type { View } from './layer.js';

/** Loads data of frames on demand, one frame at a time; frames in between are skipped during playback. */
export class FrameCache<K extends keyof FrameData, T> {
  values = new Map<number, T>();
  busy = false;
  run = 0;

  /** @param convert returns the cached form of the data */
  constructor(
    readonly kind: K,
    public convert: (answer: FrameData[K]) => T,
  ) {}

  /** Clears the cache and ignores pending loads. */
  reset() {
    this.values.clear();
    this.busy = false;
    this.run += 1;
  }

  /**
   * @param view redrawn when the data is loaded
   * @returns undefined while loading, or if not available
   */
  get(view: View, frame: number): T | undefined {
    const value = this.values.get(frame);
    const load = view.frameData[this.kind];
    if (value === undefined && !this.busy && load) this.fetch(view, frame, load);
    return value;
  }

  async fetch(view: View, frame: number, load: (frame: number) => Promise<FrameData[K]>) {
    const run = this.run;
    this.busy = true;
    try {
      const answer = await load(frame);
      if (run === this.run) this.values.set(frame, this.convert(answer));
    } catch (error) {
      // A session closed in the meantime rejects.
      if (run === this.run) console.warn(`no ${this.kind} of frame`, frame, error);
    } finally {
      if (run === this.run) {
        this.busy = false;
        if (this.values.has(frame)) view.redraw();
      }
    }
  }
}

/**
 * Draws a picture that is reused.
 * @param draw draws from the upper left corner
 */
export function drawPicture(
  { width, height }: { width: number; height: number },
  draw: (ctx: OffscreenCanvasRenderingContext2D) => void,
): OffscreenCanvas {
  const canvas = new OffscreenCanvas(width, height);
  const ctx = canvas.getContext('2d');
  if (ctx) draw(ctx);
  return canvas;
}

/**
 * Returns the value of a map at a position; undefined outside the frame.
 * @param size of the map, whose resolution may be lower than the clip's
 * @param place in clip pixels
 */
export function readValue(
  size: { width: number; height: number },
  values: Float32Array,
  clip: { width: number; height: number },
  place: { x: number; y: number },
): number | undefined {
  const x = Math.floor(((place.x + 0.5) / clip.width) * size.width);
  const y = Math.floor(((place.y + 0.5) / clip.height) * size.height);
  return x >= 0 && y >= 0 && x < size.width && y < size.height ? values[y * size.width + x] : undefined;
}
