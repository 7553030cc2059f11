/** Pictures as large as the frame: the frame itself, its masks, the scene without the objects. @module */

import { drawLabels } from '../library.js';
import { key } from '../dom.js';
import { fromCorner, opacity } from './layer.js';
import { objectColor } from '../result/palette.js';
import { Fetched, picture } from './fetched.js';
import { NOTHING } from '../words.js';

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

/** What holes are filled with. */
const HOLE = '#d6409f';

/** @returns {import('./layer.js').Layer} */
export function backgroundLayer() {
  const plates = new Fetched('background', (plate) =>
    picture(plate, (ctx) => {
      ctx.putImageData(new ImageData(plate.data, plate.width, plate.height), 0, 0);
      ctx.globalCompositeOperation = 'destination-over';
      ctx.fillStyle = HOLE;
      ctx.fillRect(0, 0, plate.width, plate.height);
    }),
  );
  return {
    id: 'background',
    name: 'Background',
    key: 'b',
    only: 'clip',
    about: 'The scene without the objects, as other frames show it.',
    z: 2,
    on: false,
    settings: { opacity: opacity() },
    legend: () => [key('dot', HOLE, 'never seen')],
    missing: ({ points }) => (points && !points.hasMasks ? NOTHING.masks : ''),
    reset: () => plates.reset(),
    draw(ctx, view) {
      const plate = view.points && plates.get(view, view.frame);
      if (!plate) return;
      ctx.imageSmoothingQuality = 'high';
      ctx.drawImage(plate, -0.5, -0.5, view.width, view.height);
    },
  };
}

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
