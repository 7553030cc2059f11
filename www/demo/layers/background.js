/** The clean plate: the frame as it would be without the objects. @module */

import { key } from '../dom.js';
import { Fetched } from './fetched.js';
import { opacity } from './layer.js';
import { picture } from './regions.js';
import { NOTHING } from '../words.js';

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
