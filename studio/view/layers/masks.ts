// Pictures as large as the frame: the frame itself, and its masks.

import { drawLabels } from '../../model/library.js';
import { type Layer, fromCorner, opacity } from './layer.js';

/** Width of the outline in CSS pixels. */
export const OUTLINE = 1.8;

export function maskLayer(): Layer {
  const fill = { ...opacity(0.5), name: 'Fill' };
  return {
    id: 'masks',
    name: 'Masks',
    key: '1',
    only: 'clip',
    about: 'Every pixel that belongs to an object, in its colour.',
    z: 30,
    on: true,
    settings: { opacity: opacity(), fill },
    legend: () => [],
    draw(ctx, { mask, unit, visible }) {
      const edged = mask();
      if (!edged) return;
      const masks = { ...edged, numFrames: 1, labels: () => edged.labels };
      const objects = (object: number) => object > 0 && visible(object);
      fromCorner(ctx, () => drawLabels(ctx, masks, 0, { opacity: fill.value, outlineWidth: OUTLINE * unit, objects }));
    },
  };
}

export function imageLayer(): Layer {
  const color = { ...opacity(0.5), name: 'Colour' };
  return {
    id: 'image',
    name: 'Source image',
    key: '9',
    about: 'The frame itself, a little pale so that the layers stand out.',
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
