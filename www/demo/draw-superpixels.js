/** The Gabriel superpixels of the frame, in their mean colours or in colours at random. @module */

import { Fetched } from './fetched.js';
import { opacity, toggle } from './layer.js';
import { flowColor } from './palette.js';
import { packed, paintRegions } from './regions.js';

/** @typedef {import('./layer.js').Superpixels} Superpixels */

const LINE = packed(20, 22, 26, 200);

/** @returns {import('./layer.js').Layer} */
export function superpixelLayer() {
  const mean = toggle('Mean colour', true);
  /** @type {Map<string, OffscreenCanvas>} */
  const pictures = new Map();
  const regions = new Fetched('superpixels', (superpixels) => superpixels);
  return {
    id: 'superpixels',
    name: 'Superpixels',
    key: '3',
    about: 'Pieces of the frame that lie between its contours, gaps bridged; each belongs to one object.',
    z: 12,
    on: false,
    settings: { opacity: opacity(0.9), mean },
    legend: () => [],
    reset() {
      pictures.clear();
      regions.reset();
    },
    draw(ctx, view) {
      const known = regions.get(view, view.frame);
      if (!known) return;
      const key = `${view.frame} ${mean.value}`;
      const picture = pictures.get(key) ?? paint(known, mean.value > 0 ? meanColors(known, view.image) : randomColors(known));
      pictures.set(key, picture);
      ctx.drawImage(picture, -0.5, -0.5, view.width, view.height);
    },
  };
}

/**
 * @param {Superpixels} superpixels
 * @param {Uint32Array} colors
 */
function paint({ label, width, height }, colors) {
  return paintRegions(label, width, height, colors, LINE);
}

/**
 * @param {Superpixels} superpixels
 * @param {CanvasImageSource | null} image
 * @returns {Uint32Array}
 */
function meanColors({ label, width, height, count }, image) {
  const ctx = /** @type {OffscreenCanvasRenderingContext2D} */ (
    new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true })
  );
  if (image) ctx.drawImage(image, 0, 0, width, height);
  const { data } = ctx.getImageData(0, 0, width, height);
  const sum = new Float64Array(4 * count);
  for (let p = 0; p < label.length; p++) {
    const at = 4 * label[p];
    for (let c = 0; c < 3; c++) sum[at + c] += data[4 * p + c];
    sum[at + 3] += 1;
  }
  return Uint32Array.from({ length: count }, (_, k) => {
    const [r, g, b, n] = sum.subarray(4 * k, 4 * k + 4);
    return packed(r / n, g / n, b / n, 255);
  });
}

/**
 * @param {Superpixels} superpixels
 * @returns {Uint32Array} hues in steps of the golden angle, so that neighbours differ
 */
function randomColors({ count }) {
  const rgba = new Uint8ClampedArray(4);
  return Uint32Array.from({ length: count }, (_, k) => {
    const turn = k * 2.399963;
    flowColor(Math.cos(turn), Math.sin(turn), 1.35 + 0.35 * (k % 3), rgba, 0);
    return packed(rgba[0], rgba[1], rgba[2], 255);
  });
}
