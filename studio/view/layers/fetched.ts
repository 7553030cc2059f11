// What layers draw: answers that are fetched when a layer first looks at a frame, and pictures of one value a pixel.

import type { Answer } from '../../model/answers.js';
import type { View } from './layer.js';

/** Answers by frame, one question at a time: while the clip plays, frames in between are passed over. */
export class Fetched<K extends keyof Answer, T> {
  known = new Map<number, T>();
  busy = false;
  run = 0;

  /** @param made what is kept of an answer */
  constructor(
    readonly what: K,
    public made: (answer: Answer[K]) => T,
  ) {}

  /** Forgets everything, also what is on its way. */
  reset() {
    this.known.clear();
    this.busy = false;
    this.run += 1;
  }

  /**
   * @param view is drawn again when the answer has come
   * @returns undefined as long as it is on its way, and where nobody knows
   */
  get(view: View, frame: number): T | undefined {
    const known = this.known.get(frame);
    const ask = view.answers[this.what];
    if (known === undefined && !this.busy && ask) this.fetch(view, frame, ask);
    return known;
  }

  async fetch(view: View, frame: number, ask: (frame: number) => Promise<Answer[K]>) {
    const asked = this.run;
    this.busy = true;
    try {
      const answer = await ask(frame);
      if (asked === this.run) this.known.set(frame, this.made(answer));
    } catch (error) {
      // A session that was closed meanwhile answers nobody.
      if (asked === this.run) console.warn(`no ${this.what} of frame`, frame, error);
    } finally {
      if (asked === this.run) {
        this.busy = false;
        if (this.known.has(frame)) view.redraw();
      }
    }
  }
}

/**
 * Paints a picture once, to be drawn over the frame again and again.
 * @param draw fills it from the upper left corner
 */
export function picture(
  { width, height }: { width: number; height: number },
  draw: (ctx: OffscreenCanvasRenderingContext2D) => void,
): OffscreenCanvas {
  const canvas = new OffscreenCanvas(width, height);
  const ctx = canvas.getContext('2d');
  if (ctx) draw(ctx);
  return canvas;
}

/** Keeps the last picture, so that a redraw of the same costs nothing. */
export class LastPicture {
  key = '';
  canvas: OffscreenCanvas | null = null;

  reset() {
    this.canvas = null;
  }

  get(key: string, make: () => OffscreenCanvas) {
    if (key !== this.key || !this.canvas) this.canvas = make();
    this.key = key;
    return this.canvas;
  }
}

/**
 * @param size of the map, whose pixels may be larger than those of the clip
 * @param place in clip pixels
 * @returns the map's value there; undefined outside of the frame
 */
export function valueAt(
  size: { width: number; height: number },
  values: Float32Array,
  clip: { width: number; height: number },
  place: { x: number; y: number },
): number | undefined {
  const x = Math.floor(((place.x + 0.5) / clip.width) * size.width);
  const y = Math.floor(((place.y + 0.5) / clip.height) * size.height);
  return x >= 0 && y >= 0 && x < size.width && y < size.height ? values[y * size.width + x] : undefined;
}
