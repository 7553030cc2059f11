/** The embedding as colour: three eigenvectors as red, green and blue, spread over the cells of the points. @module */

import { CellPainter, packColors } from './cells.js';
import { h } from './dom.js';
import { opacity } from './layer.js';
import { quantile } from './points.js';

/** Eigenvectors shown: the first is constant on a connected graph and says nothing. */
const CHANNELS = [1, 2, 3];

/** @returns {import('./layer.js').Layer} */
export function embeddingLayer() {
  /** @type {Uint32Array | null} */
  let colors = null;
  const cells = new CellPainter((view) => {
    colors ??= embeddingColors(/** @type {import('./points.js').Points} */ (view.points).result);
    return colors;
  }, 1);
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
      if (!view.points) return;
      ctx.imageSmoothingEnabled = false;
      cells.draw(ctx, view);
      ctx.imageSmoothingEnabled = true;
    },
  };
}

/**
 * @param {import('./points.js').Result} result
 * @returns {Uint32Array} an opaque colour per trajectory; each channel spans 2 % to 98 % of its values
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
  return packColors(n, (i, out, at) => {
    channels.forEach((values, channel) => (out[at + channel] = 44 + 200 * values[i]));
    out[at + 3] = 255;
  });
}
