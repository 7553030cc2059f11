/** The boundary probability Pb, dark on white; maps are computed when they are first looked at. @module */

import { Fetched } from './fetched.js';
import { opacity, toggle } from './layer.js';
import { valueAt } from './regions.js';

/** Pb that gets full black: stronger boundaries are rare, and weak ones are what matters. */
const BLACK = 0.6;

/** @returns {import('./layer.js').Layer} */
export function boundaryLayer() {
  const thin = toggle('Ridges only', false);
  const maps = new Fetched('boundaries', (map) => ({ map, pb: paintStrength(map.pb, map), thin: paintStrength(map.thin, map) }));
  return {
    id: 'boundaries',
    name: 'Boundaries (Pb)',
    key: '5',
    about: 'How likely each pixel lies on a boundary, from brightness, colour and texture; computed when first shown.',
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
 * @param {Float32Array} values in 0..1
 * @param {{width: number, height: number}} size
 * @param {number} [white] strength up to which pixels stay white
 * @param {number} [black] strength from which they are black
 * @returns {OffscreenCanvas} strong boundaries dark on white
 */
export function paintStrength(values, { width, height }, white = 0, black = BLACK) {
  const image = new ImageData(width, height);
  const span = Math.max(black - white, 1e-6);
  values.forEach((value, p) => {
    // The root lifts weak boundaries into sight.
    const shade = 255 * (1 - Math.sqrt(Math.min(1, Math.max(0, value - white) / span)));
    image.data.set([shade, shade, shade, 255], 4 * p);
  });
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}
