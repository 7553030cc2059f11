/** Paints each pixel like the nearest point of the frame, up to some distance. @module */

/** @typedef {import('./layer.js').View} View */

/** Keeps the last picture, so that a redraw of the same frame costs nothing. */
export class CellPainter {
  /**
   * @param {(view: View) => Uint32Array} colorsOf the colour of each trajectory as bytes red, green, blue, alpha in memory
   *   order; 0 leaves its cell clear
   * @param {number} steps how far from a point is painted, in distances between neighbouring points
   */
  constructor(colorsOf, steps) {
    this.colorsOf = colorsOf;
    this.steps = steps;
    this.key = '';
    /** @type {OffscreenCanvas | null} */
    this.canvas = null;
  }

  reset() {
    this.key = '';
    this.canvas = null;
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {View} view
   */
  draw(ctx, view) {
    const points = /** @type {import('./points.js').Points} */ (view.points);
    const shown = Array.from({ length: points.count }, (_, k) => view.visible(k));
    const key = `${view.frame} ${shown}`;
    const reach = Math.max(2, this.steps * points.spacing(view.frame));
    if (key !== this.key || !this.canvas) this.canvas = paint(view, points, reach, this.colorsOf(view), shown);
    this.key = key;
    ctx.drawImage(this.canvas, -0.5, -0.5, view.width, view.height);
  }
}

/**
 * @param {View} view
 * @param {import('./points.js').Points} points
 * @param {number} reach in pixels of the clip
 * @param {Uint32Array} colors
 * @param {boolean[]} shown for each object
 * @returns {OffscreenCanvas} at clip size
 */
function paint({ width, height, frame }, points, reach, colors, shown) {
  const { id, x, y } = points.at(frame);
  const nearest = new Float32Array(width * height).fill(reach * reach);
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  for (let k = 0; k < id.length; k++) {
    // Hidden objects keep their cells: neighbours must not grow into them.
    const color = shown[points.object[id[k]]] ? colors[id[k]] : 0;
    const lastY = Math.min(height - 1, Math.floor(y[k] + reach));
    const lastX = Math.min(width - 1, Math.floor(x[k] + reach));
    for (let py = Math.max(0, Math.ceil(y[k] - reach)); py <= lastY; py++) {
      for (let px = Math.max(0, Math.ceil(x[k] - reach)); px <= lastX; px++) {
        const sq = (px - x[k]) ** 2 + (py - y[k]) ** 2;
        const at = py * width + px;
        if (sq >= nearest[at]) continue;
        nearest[at] = sq;
        pixels[at] = color;
      }
    }
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}

/**
 * @param {number} count
 * @param {(trajectory: number, out: Uint8Array, at: number) => void} write red, green, blue and alpha at `at`
 * @returns {Uint32Array}
 */
export function packColors(count, write) {
  const bytes = new Uint8Array(4 * count);
  for (let i = 0; i < count; i++) write(i, bytes, 4 * i);
  return new Uint32Array(bytes.buffer);
}
