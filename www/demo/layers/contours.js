/** The edges that superpixels are made of, as in Figure 8 of the paper: contours red, Gabriel edges green. @module */

import { drawSuperpixels } from '../../dist/draw.js';
import { key } from '../dom.js';
import { Fetched } from './fetched.js';
import { fromCorner, opacity, toggle } from './layer.js';
import { EDGE_STYLES } from '../result/palette.js';

/** Width of contours in CSS pixels. */
const WIDTH = 1.6;

/** @returns {import('./layer.js').Layer} */
export function contourLayer() {
  const deleted = toggle('Deleted edges', false);
  const regions = new Fetched('superpixels', (superpixels) => superpixels);
  return {
    id: 'contours',
    name: 'Contours',
    key: '4',
    about: 'Lines fitted to the contours, and the Gabriel edges that bridge the gaps between them.',
    ofWindows: true,
    z: 50,
    on: false,
    settings: { opacity: opacity(), deleted },
    legend: () => [
      key('line', EDGE_STYLES.Constraint.color, 'contours'),
      key('line', EDGE_STYLES.Gabriel.color, 'Gabriel edges'),
      key('thin', 'currentcolor', 'Delaunay edges deleted'),
    ],
    reset: () => regions.reset(),
    draw(ctx, view) {
      const known = regions.get(view, view.frame);
      if (!known) return;
      /** @type {import('../../dist/draw.js').DrawSuperpixelsOptions} */
      const options = {
        fill: 'none',
        borders: false,
        edges: true,
        deleted: deleted.value > 0,
        width: WIDTH * view.unit,
      };
      fromCorner(ctx, () => drawSuperpixels(ctx, known, options));
    },
  };
}
