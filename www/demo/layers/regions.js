/** Pictures of a frame that are kept, and what their values are at a place. @module */

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
