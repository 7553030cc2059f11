// Cut-out objects with their trail, pixel by pixel: the same bytes everywhere.

import { boxOf, firstOf, framesOf } from '../draw/cutout.js';

/** @typedef {import('../draw/cutout.js').TrailOptions} TrailOptions */

/**
 * Pixels of the objects of a frame, RGBA with the objects' opacity, in a box of the frame.
 * @typedef {{x: number, y: number, width: number, height: number, data: Uint8ClampedArray}} CutPixels
 */

/**
 * Objects with what lies behind them, row by row: colours (RGBA, whose alpha is of no meaning), and how opaque they are.
 * @typedef {{data: Uint8ClampedArray<ArrayBuffer>, alpha: Uint8Array<ArrayBuffer>}} Composed
 */

/** Objects with their trail, frame after frame; keeps the pixels of the objects that later frames need. */
export class Trails {
  /**
   * @param {Required<TrailOptions>} trail
   * @param {import('../check/masks.js').MaskSource['shots']} shots
   */
  constructor(trail, shots) {
    this.trail = trail;
    this.shots = shots;
    /** @type {Map<number, CutPixels | null>} By frame; null where there is no object. */
    this.kept = new Map();
  }

  /**
   * @param {number} t frames come in order, from the first on
   * @param {import('../worker/frames.js').PixelFrame} picture RGBA
   * @param {Uint8Array} alpha how opaque the objects are at each of its pixels
   * @returns {Composed}
   */
  next(t, picture, alpha) {
    const own = cutPixels(picture, alpha);
    const layers = framesOf(t, this.trail, firstOf(t, this.shots)).map((one) => ({
      cut: this.kept.get(one.t) ?? null,
      opacity: one.opacity,
    }));
    this.kept.set(t, own);
    this.kept.delete(t - this.trail.copies * this.trail.spacing);
    return composed([...layers, { cut: own, opacity: 1 }], picture);
  }
}

/**
 * @param {import('../worker/frames.js').PixelFrame} picture
 * @param {Uint8Array} alpha
 * @returns {CutPixels | null} null where all is clear
 */
function cutPixels({ data: pixels, width: across, height: down }, alpha) {
  const box = boxOf(alpha, across, down);
  if (!box) return null;
  const { x, y, width, height } = box;
  const data = new Uint8ClampedArray(4 * width * height);
  for (let row = 0; row < height; row += 1) {
    const from = (y + row) * across + x;
    data.set(pixels.subarray(4 * from, 4 * (from + width)), 4 * row * width);
    for (let k = 0; k < width; k += 1) data[4 * (row * width + k) + 3] = Number(alpha[from + k]);
  }
  return { ...box, data };
}

/**
 * Lays pictures over each other, the last on top.
 * @param {readonly {cut: CutPixels | null, opacity: number}[]} layers
 * @param {{width: number, height: number}} size
 * @returns {Composed}
 */
function composed(layers, { width, height }) {
  const data = new Uint8ClampedArray(4 * width * height);
  const alpha = new Uint8Array(width * height);
  const there = /** @type {{cut: CutPixels, opacity: number}[]} */ (layers.filter(({ cut }) => cut)).reverse();
  const top = Math.min(...there.map(({ cut }) => cut.y));
  const bottom = Math.max(...there.map(({ cut }) => cut.y + cut.height));
  for (let y = top; y < bottom; y += 1) {
    const row = there.filter(({ cut }) => y >= cut.y && y < cut.y + cut.height);
    const left = Math.min(...row.map(({ cut }) => cut.x));
    const right = Math.max(...row.map(({ cut }) => cut.x + cut.width));
    for (let x = left; x < right; x += 1) lay(row, x, y, y * width + x, data, alpha);
  }
  return { data, alpha };
}

/**
 * One pixel: from the front to the back, as long as anything shines through.
 * @param {readonly {cut: CutPixels, opacity: number}[]} layers from the front
 * @param {number} x
 * @param {number} y
 * @param {number} p
 * @param {Uint8ClampedArray} data
 * @param {Uint8Array} alpha
 */
function lay(layers, x, y, p, data, alpha) {
  let [red, green, blue, through] = [0, 0, 0, 1];
  for (const { cut, opacity } of layers) {
    const [u, v] = [x - cut.x, y - cut.y];
    if (u < 0 || u >= cut.width) continue;
    const at = 4 * (v * cut.width + u);
    const part = (opacity * Number(cut.data[at + 3])) / 255;
    red += through * part * Number(cut.data[at]);
    green += through * part * Number(cut.data[at + 1]);
    blue += through * part * Number(cut.data[at + 2]);
    through *= 1 - part;
    if (through === 0) break;
  }
  const seen = 1 - through;
  alpha[p] = Math.round(255 * seen);
  if (alpha[p] === 0) return;
  data[4 * p] = red / seen;
  data[4 * p + 1] = green / seen;
  data[4 * p + 2] = blue / seen;
  data[4 * p + 3] = 255;
}
