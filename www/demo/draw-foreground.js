/** The foreground: trajectories that stand out in red, the others faint, as in the top row of Figure 7(a) of the paper. @module */

import { key } from './dom.js';
import { opacity } from './layer.js';
import { drawMarkers, drawTrails, markerRadius } from './markers.js';
import { CUT_RED, FAINT } from './palette.js';
import { NOTHING, count } from './words.js';

/** The background's points are smaller by this. */
const FAINT_SIZE = 0.55;

/** @returns {import('./layer.js').Layer} */
export function foregroundLayer() {
  const trail = {
    name: 'Trail',
    value: 5,
    min: 0,
    max: 24,
    step: 1,
    text: (/** @type {number} */ v) => (v === 0 ? 'none' : `${v} frames`),
  };
  /** Words of the legend: how many there are, once that is known. */
  let counted = '';
  /** @type {import('./layer.js').Layer} */
  const layer = {
    id: 'foreground',
    name: 'Foreground',
    key: 'f',
    only: 'clip',
    about: 'Trajectories that stand out enough, among those that move like them, to be part of something that moves.',
    z: 62,
    on: false,
    settings: { opacity: opacity(), trail },
    legend: () => [
      key('dot', CUT_RED, `foreground${counted}`),
      key('dot', FAINT, 'all others'),
    ],
    missing({ points }) {
      if (!points) return '';
      const { saliency } = points.result;
      if (!saliency) return NOTHING.motion;
      return saliency.foreground.includes(1) ? '' : NOTHING.foreground;
    },
    reset() {
      counted = '';
    },
    draw(ctx, view) {
      const { points } = view;
      if (!points?.result.saliency) return;
      const { foreground } = points.result.saliency;
      if (counted === '') {
        counted = `, ${count(foreground.reduce((n, f) => n + f, 0))} of ${count(foreground.length)}`;
        layer.changed?.();
      }
      const ids = [...points.at(view.frame).id].filter((id) => view.visible(points.object[id]));
      const salient = ids.filter((id) => foreground[id]);
      const radius = markerRadius(view);
      drawMarkers(ctx, view, ids.filter((id) => !foreground[id]), { color: FAINT, radius: FAINT_SIZE * radius, rim: false });
      drawTrails(ctx, view, salient, { color: CUT_RED, strength: 0.9, width: 1.5 }, trail.value);
      drawMarkers(ctx, view, salient, { color: CUT_RED, radius });
    },
    readout({ points }, { trajectory }) {
      const { foreground } = points?.result.saliency ?? {};
      if (!foreground || trajectory < 0) return '';
      return foreground[trajectory] ? 'foreground' : 'not foreground';
    },
  };
  return layer;
}
