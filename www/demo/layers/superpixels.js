/** The Gabriel superpixels of the frame, in their mean colours or in colours at random. @module */

import { drawSuperpixels } from '../../dist/draw.js';
import { Fetched } from './fetched.js';
import { opacity, toggle } from './layer.js';
import { picture } from './regions.js';

/** Pixels of the picture along one of the superpixels' grid, so that lines between them are finer than that. */
const FINE = 3;

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
    ofWindows: true,
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
      const canvas = pictures.get(key) ?? paint(known, mean.value > 0 ? view.image : null);
      pictures.set(key, canvas);
      ctx.drawImage(canvas, -0.5, -0.5, view.width, view.height);
    },
  };
}

/**
 * @param {import('./layer.js').Superpixels} superpixels
 * @param {CanvasImageSource | null} image for mean colours
 */
function paint(superpixels, image) {
  const { width, height } = superpixels;
  return picture({ width: FINE * width, height: FINE * height }, (ctx) => {
    ctx.scale(FINE, FINE);
    drawSuperpixels(ctx, { ...superpixels, scaleX: 1, scaleY: 1 }, image ? { image } : {});
  });
}
