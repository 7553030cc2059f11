/** Embedding discontinuities on the Delaunay edges of the frame. @module */

import { drawDiscontinuities } from '../../dist/draw.js';
import { key } from '../dom.js';
import { fromCorner, opacity } from './layer.js';
import { CUT_RED } from '../result/palette.js';

/** Width of a middling discontinuity in CSS pixels. */
const WIDTH = 2;

/** @returns {import('./layer.js').Layer} */
export function discontinuityLayer() {
  const threshold = {
    name: 'Above',
    value: 0.6,
    min: 0.05,
    max: 0.95,
    step: 0.05,
    text: (/** @type {number} */ v) => v.toFixed(2),
  };
  return {
    id: 'discontinuities',
    name: 'Discontinuities',
    key: '6',
    only: 'clip',
    about: 'Neighbouring points whose motions part: there an object ends.',
    z: 70,
    on: false,
    settings: { opacity: opacity(), threshold },
    legend: () => [key('line', CUT_RED, 'motions part'), key('thin', 'currentcolor', 'neighbours that move alike')],
    draw(ctx, { points, frame, unit, visible }) {
      if (!points) return;
      const options = { threshold: threshold.value, width: WIDTH * unit, objects: visible };
      fromCorner(ctx, () => drawDiscontinuities(ctx, points.result, frame, options));
    },
  };
}
