/** The masks: every pixel of an object in the object's colour, with an outline. @module */

import { key } from './dom.js';
import { opacity } from './layer.js';
import { objectColor, rgbOf } from './palette.js';
import { outlines, packed, paintLabels } from './regions.js';

/** Width of the outline and of its dark rim, which keeps it legible on bright footage, in CSS pixels. */
const LINE = { color: 1.8, rim: 3.4 };

/** @returns {import('./layer.js').Layer} */
export function maskLayer() {
  const fill = { ...opacity(0.5), name: 'Fill' };
  let painted = '';
  /** @type {{picture: OffscreenCanvas, lines: Path2D[]} | null} */
  let last = null;
  return {
    id: 'masks',
    name: 'Masks',
    key: '1',
    only: 'clip',
    about: 'Every pixel that belongs to an object, in its colour.',
    z: 30,
    on: true,
    settings: { opacity: opacity(), fill },
    legend: () => [key('dot', objectColor(1), 'objects, colours as listed')],
    reset() {
      last = null;
    },
    draw(ctx, view) {
      const { points } = view;
      const mask = points?.mask(view.frame);
      if (!points || !mask) return;
      const visible = Array.from({ length: points.count }, (_, object) => object > 0 && view.visible(object));
      const wanted = `${view.frame} ${fill.value} ${visible}`;
      if (wanted !== painted || !last) {
        last = {
          picture: paintLabels(mask, view.width, view.height, colors(visible, fill.value)),
          lines: outlines(mask, view.width, view.height, points.count),
        };
      }
      painted = wanted;
      ctx.drawImage(last.picture, -0.5, -0.5, view.width, view.height);
      const { lines } = last;
      visible.forEach((on, object) => on && strokeOutline(ctx, view, lines[object], objectColor(object)));
    },
  };
}

/**
 * @param {boolean[]} visible for each object
 * @param {number} alpha
 * @returns {Uint32Array} the colour of each object, clear for those that are not
 */
function colors(visible, alpha) {
  return Uint32Array.from(visible, (on, object) => {
    const { r, g, b } = rgbOf(objectColor(object));
    return on ? packed(r, g, b, 255 * alpha) : 0;
  });
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./layer.js').View} view
 * @param {Path2D} line
 * @param {string} color
 */
function strokeOutline(ctx, view, line, color) {
  ctx.lineCap = 'round';
  for (const [style, width] of /** @type {const} */ ([['rgb(0 0 0 / 0.3)', LINE.rim], [color, LINE.color]])) {
    ctx.strokeStyle = style;
    ctx.lineWidth = width * view.unit;
    ctx.stroke(line);
  }
}
