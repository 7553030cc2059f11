/** The masks: every pixel of an object in the object's colour. @module */

import { key } from './dom.js';
import { opacity } from './layer.js';
import { objectColor, rgbOf } from './palette.js';
import { packed, paintRegions } from './regions.js';

/** @returns {import('./layer.js').Layer} */
export function maskLayer() {
  const fill = { ...opacity(0.5), name: 'Fill' };
  let shown = '';
  /** @type {OffscreenCanvas | null} */
  let picture = null;
  return {
    id: 'masks',
    name: 'Masks',
    about: 'Every pixel of an object, in the colour of its points.',
    z: 30,
    on: true,
    settings: { opacity: opacity(), fill },
    legend: () => [key('dot', objectColor(1), 'objects, colours as listed')],
    reset() {
      shown = '';
      picture = null;
    },
    draw(ctx, view) {
      const { points } = view;
      const mask = points?.mask(view.frame);
      if (!points || !mask) return;
      const visible = Array.from({ length: points.count }, (_, k) => k > 0 && view.visible(k));
      const wanted = `${view.frame} ${fill.value} ${visible}`;
      if (wanted !== shown || !picture) picture = paint(mask, view, visible, fill.value);
      shown = wanted;
      ctx.imageSmoothingEnabled = true;
      ctx.drawImage(picture, -0.5, -0.5, view.width, view.height);
    },
  };
}

/**
 * @param {Uint8Array} mask
 * @param {import('./layer.js').View} view
 * @param {boolean[]} visible for each object
 * @param {number} alpha of the inside
 */
function paint(mask, { width, height }, visible, alpha) {
  const colors = (/** @type {number} */ strength) =>
    Uint32Array.from(visible, (on, object) => {
      const { r, g, b } = rgbOf(objectColor(object));
      return on ? packed(r, g, b, 255 * strength) : 0;
    });
  return paintRegions(mask, width, height, colors(alpha), colors(1));
}
