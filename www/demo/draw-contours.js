/** The edges that superpixels are made of, as in Figure 8 of the paper: contours red, Gabriel edges green. @module */

import { key } from './dom.js';
import { Fetched } from './fetched.js';
import { opacity, toggle } from './layer.js';

/** @typedef {Record<'Constraint' | 'Frame' | 'Gabriel' | 'Deleted', number>} EdgeKind The package's numbers of kinds. */

const CONTOUR_RED = '#ff3b30';
const GABRIEL_GREEN = '#30d158';
const DELETED_GREY = 'rgb(255 255 255 / 0.35)';

/**
 * @param {EdgeKind} kinds
 * @returns {import('./layer.js').Layer}
 */
export function contourLayer(kinds) {
  const deleted = toggle('Deleted edges', false);
  /** @type {Map<number, Path2D[]>} */
  const paths = new Map();
  const regions = new Fetched('superpixels', (superpixels) => superpixels);
  return {
    id: 'contours',
    name: 'Contours',
    key: '4',
    about: 'Lines fitted to the contours, and the Gabriel edges that bridge the gaps between them.',
    z: 50,
    on: false,
    settings: { opacity: opacity(), deleted },
    legend: () => [
      key('line', CONTOUR_RED, 'contours'),
      key('line', GABRIEL_GREEN, 'Gabriel edges'),
      key('thin', 'currentcolor', 'Delaunay edges deleted'),
    ],
    reset() {
      paths.clear();
      regions.reset();
    },
    draw(ctx, view) {
      const known = regions.get(view, view.frame);
      if (!known) return;
      const drawn = paths.get(view.frame) ?? pathsOf(known, Object.keys(kinds).length);
      paths.set(view.frame, drawn);
      const stroke = (/** @type {number} */ kind, /** @type {string} */ color, /** @type {number} */ width) => {
        ctx.strokeStyle = color;
        ctx.lineWidth = width * view.unit;
        ctx.stroke(drawn[kind]);
      };
      ctx.lineCap = 'round';
      if (deleted.value > 0) stroke(kinds.Deleted, DELETED_GREY, 0.8);
      stroke(kinds.Gabriel, GABRIEL_GREEN, 1.2);
      stroke(kinds.Constraint, CONTOUR_RED, 1.6);
    },
  };
}

/**
 * @param {import('./layer.js').Superpixels} superpixels
 * @param {number} count number of kinds
 * @returns {Path2D[]} the edges of each kind, in pixels of the clip
 */
function pathsOf({ edges, scaleX, scaleY }, count) {
  const paths = Array.from({ length: count }, () => new Path2D());
  const place = (/** @type {number} */ v, /** @type {number} */ scale) => (v + 0.5) * scale - 0.5;
  edges.kind.forEach((kind, e) => {
    paths[kind].moveTo(place(edges.x0[e], scaleX), place(edges.y0[e], scaleY));
    paths[kind].lineTo(place(edges.x1[e], scaleX), place(edges.y1[e], scaleY));
  });
  return paths;
}
