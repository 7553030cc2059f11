/**
 * The foreground: trajectories that stand out in red, the others faint, as in the top row of Figure 7(a) of the paper.
 * @module
 */

import { drawTrajectories } from '../../dist/draw.js';
import { key } from '../dom.js';
import { fromCorner, opacity } from './layer.js';
import { markerSize, trailLength } from './markers.js';
import { CUT_RED, FAINT } from '../result/palette.js';
import { NOTHING, count } from '../words.js';
import { say } from '../language.js';

/** The background's points are smaller by this. */
const FAINT_SIZE = 0.55;

/** @returns {import('./layer.js').Layer} */
export function foregroundLayer() {
  const trail = trailLength(5);
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
    legend: () => [key('dot', CUT_RED, counted || 'foreground'), key('dot', FAINT, 'all others')],
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
        const those = foreground.reduce((n, f) => n + f, 0);
        counted = say`foreground, ${count(those)} of ${count(foreground.length)}`;
        layer.changed?.();
      }
      const { radius, width } = markerSize(view);
      const draw = (/** @type {import('../../dist/draw.js').DrawTrajectoriesOptions} */ options) =>
        drawTrajectories(ctx, points.result, view.frame, { objects: view.visible, width, ...options });
      fromCorner(ctx, () => {
        draw({ which: (i) => !foreground[i], color: FAINT, radius: FAINT_SIZE * radius, rim: false, tail: 0 });
        draw({ which: (i) => foreground[i] === 1, color: CUT_RED, radius, tail: trail.value });
      });
    },
    readout({ points }, { trajectory }) {
      const { foreground } = points?.result.saliency ?? {};
      if (!foreground || trajectory < 0) return '';
      return foreground[trajectory] ? say('foreground') : say('not foreground');
    },
  };
  return layer;
}
