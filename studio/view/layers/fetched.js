/**
 * What layers draw: answers that are fetched when a layer first looks at a frame, and pictures of one value a pixel.
 * @module
 */

/** @typedef {import('./layer.js').View} View */
/** @typedef {import('../../model/answers.js').Answer} Answer */

/**
 * Answers by frame, one question at a time: while the clip plays, frames in between are passed over.
 *
 * @template {keyof Answer} K
 * @template T
 */
export class Fetched {
  /**
   * @param {K} what
   * @param {(answer: Answer[K]) => T} made what is kept of an answer
   */
  constructor(what, made) {
    this.what = what;
    this.made = made;
    /** @type {Map<number, T>} */
    this.known = new Map();
    this.busy = false;
    this.run = 0;
  }

  /** Forgets everything, also what is on its way. */
  reset() {
    this.known.clear();
    this.busy = false;
    this.run += 1;
  }

  /**
   * @param {View} view is drawn again when the answer has come
   * @param {number} frame
   * @returns {T | undefined} undefined as long as it is on its way, and where nobody knows
   */
  get(view, frame) {
    const known = this.known.get(frame);
    const ask = /** @type {((frame: number) => Promise<Answer[K]>) | null} */ (view.answers[this.what]);
    if (known === undefined && !this.busy && ask) this.fetch(view, frame, ask);
    return known;
  }

  /**
   * @param {View} view
   * @param {number} frame
   * @param {(frame: number) => Promise<Answer[K]>} ask
   */
  async fetch(view, frame, ask) {
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
 *
 * @param {{width: number, height: number}} size
 * @param {(ctx: OffscreenCanvasRenderingContext2D) => void} draw fills it from the upper left corner
 * @returns {OffscreenCanvas}
 */
export function picture({ width, height }, draw) {
  const canvas = new OffscreenCanvas(width, height);
  const ctx = canvas.getContext('2d');
  if (ctx) draw(ctx);
  return canvas;
}

/** Keeps the last picture, so that a redraw of the same costs nothing. */
export class LastPicture {
  constructor() {
    this.key = '';
    /** @type {OffscreenCanvas | null} */
    this.canvas = null;
  }

  reset() {
    this.canvas = null;
  }

  /**
   * @param {string} key says what it is of
   * @param {() => OffscreenCanvas} make
   */
  get(key, make) {
    if (key !== this.key || !this.canvas) this.canvas = make();
    this.key = key;
    return this.canvas;
  }
}

/**
 * @param {{width: number, height: number}} size of the map, whose pixels may be larger than those of the clip
 * @param {Float32Array} values
 * @param {{width: number, height: number}} clip
 * @param {{x: number, y: number}} place in clip pixels
 * @returns {number | undefined} the map's value there; undefined outside of the frame
 */
export function valueAt(size, values, clip, place) {
  const x = Math.floor(((place.x + 0.5) / clip.width) * size.width);
  const y = Math.floor(((place.y + 0.5) / clip.height) * size.height);
  return x >= 0 && y >= 0 && x < size.width && y < size.height ? values[y * size.width + x] : undefined;
}
