/** The frame itself. @module */

import { opacity } from './layer.js';

/** @returns {import('./layer.js').Layer} */
export function imageLayer() {
  return {
    id: 'image',
    name: 'Source image',
    about: 'The frame itself, at the working size.',
    z: 0,
    on: true,
    settings: { opacity: opacity() },
    legend: () => [],
    draw(ctx, view) {
      if (!view.image) return;
      ctx.imageSmoothingQuality = 'high';
      ctx.drawImage(view.image, -0.5, -0.5, view.width, view.height);
    },
  };
}
