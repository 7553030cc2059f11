/** The embedding as colour: three eigenvectors as red, green and blue, spread over the cells of the points. @module */

import { h } from './dom.js';
import { opacity } from './layer.js';
import { quantile } from './points.js';

/** Eigenvectors shown: the first is constant on a connected graph and says nothing. */
const CHANNELS = [1, 2, 3];

/** @returns {import('./layer.js').Layer} */
export function embeddingLayer() {
  /** @type {Uint8Array | null} */
  let colors = null;
  /** @type {Map<number, OffscreenCanvas>} */
  const cache = new Map();
  return {
    id: 'embedding',
    name: 'Embedding colours',
    about: 'Points of like colour have moved alike over their whole life.',
    z: 20,
    on: false,
    settings: { opacity: opacity(0.85) },
    legend: () => [
      h(
        'span',
        { class: 'key' },
        ...['red', 'green', 'blue'].map((c) => h('span', { class: `chip chip-${c}`, 'aria-hidden': 'true' })),
        'eigenvectors 2, 3 and 4',
      ),
    ],
    reset() {
      colors = null;
      cache.clear();
    },
    draw(ctx, view) {
      if (!view.points) return;
      colors ??= embeddingColors(view.points.result);
      const known = cache.get(view.frame) ?? paintCells(view, colors);
      cache.set(view.frame, known);
      ctx.imageSmoothingEnabled = false;
      ctx.drawImage(known, -0.5, -0.5, view.width, view.height);
      ctx.imageSmoothingEnabled = true;
    },
  };
}

/**
 * @param {import('./points.js').Result} result
 * @returns {Uint8Array} three bytes per trajectory; each channel spans 2 % to 98 % of its values
 */
export function embeddingColors(result) {
  const { dimensions, vectors } = result.embedding;
  const n = result.trajectories.count;
  const colors = new Uint8Array(3 * n).fill(128);
  CHANNELS.forEach((column, channel) => {
    if (column >= dimensions) return;
    const values = Float32Array.from({ length: n }, (_, i) => vectors[i * dimensions + column]);
    const low = quantile(values, 0.02);
    const span = quantile(values, 0.98) - low || 1;
    values.forEach((value, i) => {
      colors[3 * i + channel] = 24 + 220 * Math.min(1, Math.max(0, (value - low) / span));
    });
  });
  return colors;
}

/**
 * Gives each pixel the colour of the nearest visible point, up to about one grid step away.
 *
 * @param {import('./layer.js').View} view
 * @param {Uint8Array} colors
 * @returns {OffscreenCanvas} at clip size
 */
function paintCells(view, colors) {
  const points = /** @type {import('./points.js').Points} */ (view.points);
  const { width, height } = view;
  const { id, x, y } = points.at(view.frame);
  const reach = Math.max(2, points.spacing(view.frame));
  const nearest = new Float32Array(width * height).fill(reach * reach);
  const image = new ImageData(width, height);
  for (let k = 0; k < id.length; k++) {
    const color = colors.subarray(3 * id[k], 3 * id[k] + 3);
    const lastY = Math.min(height - 1, Math.floor(y[k] + reach));
    const lastX = Math.min(width - 1, Math.floor(x[k] + reach));
    for (let py = Math.max(0, Math.ceil(y[k] - reach)); py <= lastY; py++) {
      for (let px = Math.max(0, Math.ceil(x[k] - reach)); px <= lastX; px++) {
        const sq = (px - x[k]) ** 2 + (py - y[k]) ** 2;
        const at = py * width + px;
        if (sq >= nearest[at]) continue;
        nearest[at] = sq;
        image.data.set(color, 4 * at);
        image.data[4 * at + 3] = 255;
      }
    }
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}
