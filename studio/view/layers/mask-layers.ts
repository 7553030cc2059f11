// Layers of the masks and of the frame itself.

import { drawLabels } from '../../model/library.js';
import { type Layer, fromCorner, opacity } from './layer.js';

/** Width of the outline in CSS pixels; chosen by eye. */
export const OUTLINE_WIDTH_PX = 1.8;

export function maskLayer(): Layer {
  const fill = { ...opacity(0), name: 'Fill' };
  return {
    id: 'masks',
    name: 'Masks',
    key: '1',
    only: 'clip',
    about: 'The outline of each object, in its colour.',
    z: 30,
    isOn: true,
    settings: { opacity: opacity(), fill },
    legend: () => [],
    draw(ctx, { mask, unit, visible }) {
      const edged = mask();
      if (!edged) return;
      const masks = { ...edged, numFrames: 1, labels: () => edged.labels };
      const objects = (object: number) => object > 0 && visible(object);
      fromCorner(ctx, () =>
        drawLabels(ctx, masks, 0, { opacity: fill.value, outlineWidth: OUTLINE_WIDTH_PX * unit, objects }),
      );
    },
  };
}

export function imageLayer(): Layer {
  return {
    id: 'image',
    name: 'Source image',
    key: '9',
    about: 'The frame itself.',
    z: 0,
    isOn: true,
    settings: { opacity: opacity() },
    legend: () => [],
    draw(ctx, view) {
      if (!view.image) return;
      ctx.imageSmoothingQuality = 'high';
      ctx.drawImage(view.image, -0.5, -0.5, view.width, view.height);
    },
  };
}
