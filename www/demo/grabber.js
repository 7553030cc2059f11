/** Reads pixels of whatever the browser can draw. @module */

export class Grabber {
  constructor() {
    this.canvas = new OffscreenCanvas(1, 1);
    this.ctx = /** @type {OffscreenCanvasRenderingContext2D} */ (
      this.canvas.getContext('2d', { willReadFrequently: true, alpha: false })
    );
  }

  /**
   * @param {CanvasImageSource} picture
   * @param {{width: number, height: number}} size the picture's own size in pixels
   * @param {number} side longest side of the answer
   * @returns {ImageData}
   */
  grab(picture, size, side) {
    const { width, height } = workingSize(size, side);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.ctx.imageSmoothingQuality = 'high';
    this.ctx.drawImage(picture, 0, 0, width, height);
    return this.ctx.getImageData(0, 0, width, height);
  }
}

/**
 * @param {{width: number, height: number}} size
 * @param {number} side
 * @returns {{width: number, height: number}} with the long side at most `side`, never enlarged
 */
export function workingSize(size, side) {
  const scale = Math.min(1, side / Math.max(size.width, size.height));
  return { width: Math.max(1, Math.round(size.width * scale)), height: Math.max(1, Math.round(size.height * scale)) };
}

/**
 * Some browsers add noise to what a page reads from a canvas, against fingerprinting. Then the same clip gives other
 * bytes each time, and results differ a little.
 *
 * @returns {boolean}
 */
export function readsAreNoisy() {
  const side = 32;
  const canvas = new OffscreenCanvas(side, side);
  const ctx = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d', { willReadFrequently: true }));
  ctx.fillStyle = 'rgb(120, 130, 140)';
  ctx.fillRect(0, 0, side, side);
  const { data } = ctx.getImageData(0, 0, side, side);
  return data.some((byte, k) => byte !== [120, 130, 140, 255][k % 4]);
}
