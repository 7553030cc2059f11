/** The boundary probability Pb, dark on white; maps are computed when they are first looked at. @module */

import { drawBoundaries } from '../../dist/draw.js';
import { Fetched } from './fetched.js';
import { opacity, toggle } from './layer.js';
import { picture, valueAt } from './regions.js';

/** @returns {import('./layer.js').Layer} */
export function boundaryLayer() {
  const thin = toggle('Ridges only', false);
  const maps = new Fetched('boundaries', (map) => ({ map, pb: paint(map, 'pb'), thin: paint(map, 'thin') }));
  return {
    id: 'boundaries',
    name: 'Boundaries (Pb)',
    key: '5',
    about: 'How likely each pixel lies on a boundary, from brightness, colour and texture; computed when first shown.',
    ofWindows: true,
    z: 14,
    on: false,
    settings: { opacity: opacity(), thin },
    legend: () => [],
    reset: () => maps.reset(),
    draw(ctx, view) {
      const known = maps.get(view, view.frame);
      if (known) ctx.drawImage(thin.value > 0 ? known.thin : known.pb, -0.5, -0.5, view.width, view.height);
    },
    readout(view, spot) {
      const map = maps.get(view, view.frame)?.map;
      const here = map && valueAt(map, map.pb, view, spot);
      return here === undefined ? '' : `Pb ${here.toFixed(2)}`;
    },
  };
}

/**
 * @param {import('./layer.js').Boundaries} map
 * @param {'pb' | 'thin'} of
 */
function paint({ width, height, ...values }, of) {
  return picture({ width, height }, (ctx) => drawBoundaries(ctx, { width, height, [of]: values[of] }, { of }));
}
