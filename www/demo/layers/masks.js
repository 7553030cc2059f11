/** The masks: every pixel of an object in the object's colour, with an outline. @module */

import { drawLabels } from '../../dist/index.js';
import { key } from '../dom.js';
import { fromCorner, opacity } from './layer.js';
import { objectColor } from '../result/palette.js';

/** Width of the outline in CSS pixels. */
export const OUTLINE = 1.8;

/** @returns {import('./layer.js').Layer} */
export function maskLayer() {
  const fill = { ...opacity(0.5), name: 'Fill' };
  return {
    id: 'masks',
    name: 'Masks',
    key: '1',
    only: 'clip',
    about: 'Every pixel that belongs to an object, in its colour.',
    ofWindows: true,
    z: 30,
    on: true,
    settings: { opacity: opacity(), fill },
    legend: () => [key('dot', objectColor(1), 'objects, colours as listed')],
    draw(ctx, { mask, unit, visible }) {
      const edged = mask();
      if (!edged) return;
      const masks = { ...edged, numFrames: 1, labels: () => edged.labels };
      const objects = (/** @type {number} */ object) => object > 0 && visible(object);
      fromCorner(ctx, () => drawLabels(ctx, masks, 0, { opacity: fill.value, outlineWidth: OUTLINE * unit, objects }));
    },
  };
}
