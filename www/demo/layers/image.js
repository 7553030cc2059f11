/** The frame itself. @module */

import { opacity } from './layer.js';

/** @returns {import('./layer.js').Layer} */
export function imageLayer() {
  const color = { ...opacity(0.5), name: 'Colour' };
  return {
    id: 'image',
    name: 'Source image',
    key: '9',
    about: 'The frame itself, a little pale so that the layers stand out.',
    ofWindows: true,
    z: 0,
    on: true,
    settings: { opacity: opacity(), color },
    legend: () => [],
    draw(ctx, view) {
      if (!view.image) return;
      ctx.imageSmoothingQuality = 'high';
      ctx.drawImage(view.image, -0.5, -0.5, view.width, view.height);
      // Blending a grey in takes saturation away; unlike a filter, all browsers can do it.
      ctx.globalCompositeOperation = 'saturation';
      ctx.globalAlpha = 1 - color.value;
      ctx.fillStyle = '#808080';
      ctx.fillRect(-0.5, -0.5, view.width, view.height);
      ctx.globalCompositeOperation = 'source-over';
      ctx.globalAlpha = 1;
    },
  };
}
