/** The embedding as colour: three eigenvectors as red, green and blue, spread over the cells of the points. @module */

import { drawCells } from '../../dist/draw.js';
import { h } from '../dom.js';
import { cellKey } from './trajectories.js';
import { fromCorner, opacity } from './layer.js';
import { quantile } from '../result/points.js';
import { LastPicture, picture } from './regions.js';

/** Eigenvectors shown: the first is constant on a connected graph and says nothing. */
const CHANNELS = [1, 2, 3];

/** @returns {import('./layer.js').Layer} */
export function embeddingLayer() {
  /** @type {string[] | null} */
  let colors = null;
  const cells = new LastPicture();
  return {
    id: 'embedding',
    name: 'Embedding colours',
    key: '7',
    only: 'clip',
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
      cells.reset();
    },
    draw(ctx, view) {
      const { points, frame, visible } = view;
      if (!points) return;
      const known = (colors ??= embeddingColors(points.result));
      const color = (/** @type {number} */ i) => (visible(points.object[i]) ? known[i] : null);
      const reach = Math.max(2, points.spacing(frame));
      const canvas = cells.get(cellKey(view), () =>
        picture(view, (own) => drawCells(own, points.result, frame, { color, reach })),
      );
      fromCorner(ctx, () => {
        ctx.imageSmoothingEnabled = false;
        ctx.drawImage(canvas, 0, 0);
      });
    },
  };
}

/**
 * @param {import('../result/points.js').Result} result
 * @returns {string[]} a colour per trajectory; each channel spans 2 % to 98 % of its values
 */
function embeddingColors(result) {
  const { dimensions, vectors } = result.embedding;
  const n = result.trajectories.count;
  const channels = CHANNELS.map((column) => {
    if (column >= dimensions) return new Float32Array(n).fill(0.5);
    const values = Float32Array.from({ length: n }, (_, i) => vectors[i * dimensions + column]);
    const low = quantile(values, 0.02);
    const span = quantile(values, 0.98) - low || 1;
    return values.map((value) => Math.min(1, Math.max(0, (value - low) / span)));
  });
  const hex = (/** @type {number} */ value) =>
    Math.floor(44 + 200 * value)
      .toString(16)
      .padStart(2, '0');
  return Array.from({ length: n }, (_, i) => `#${channels.map((values) => hex(values[i])).join('')}`);
}
