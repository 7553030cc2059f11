/** Trajectory points by object, each with the last part of its way. @module */

import { drawCells, drawTrajectories } from '../../dist/draw.js';
import { key } from '../dom.js';
import { fromCorner, opacity } from './layer.js';
import { markerSize, trailLength } from './markers.js';
import { objectColor } from '../result/palette.js';
import { NOTHING } from '../words.js';
import { LastPicture, picture } from './regions.js';

/** The tint reaches this far from a point, in distances between points: neighbours' cells just close up. */
const TINT_STEPS = 0.75;

/** @returns {import('./layer.js').Layer} */
export function trajectoryLayer() {
  const trail = trailLength(8);
  const tint = { ...opacity(0.35), name: 'Tint' };
  const cells = new LastPicture();
  return {
    id: 'trajectories',
    name: 'Trajectories',
    key: '2',
    only: 'clip',
    about: 'Points followed from frame to frame, coloured by object. Pixels are tinted like the nearest point.',
    ofWindows: true,
    z: 60,
    on: false,
    settings: { opacity: opacity(), trail, tint },
    legend: () => [key('dot', objectColor(0), 'background'), key('dot', objectColor(1), 'objects, colours as listed')],
    missing: ({ windows, points }) => (windows && !points?.result.trajectories.count ? NOTHING.joined : ''),
    reset: () => cells.reset(),
    draw(ctx, view) {
      const { points, frame, visible } = view;
      if (!points) return;
      fromCorner(ctx, () => {
        ctx.globalAlpha = tint.value;
        ctx.drawImage(
          cells.get(cellKey(view), () => tinted(view)),
          0,
          0,
        );
        ctx.globalAlpha = 1;
        drawTrajectories(ctx, points.result, frame, { tail: trail.value, objects: visible, ...markerSize(view) });
      });
    },
  };
}

/**
 * @param {import('./layer.js').View} view
 * @returns {string} what the picture of cells depends on
 */
export function cellKey({ points, frame, visible }) {
  return `${frame} ${Array.from({ length: points?.count ?? 0 }, (_, object) => visible(object))}`;
}

/** @param {import('./layer.js').View} view */
function tinted(view) {
  const { frame, visible } = view;
  const points = /** @type {import('../result/points.js').Points} */ (view.points);
  const color = (/** @type {number} */ i) =>
    points.object[i] > 0 && visible(points.object[i]) ? objectColor(points.object[i]) : null;
  const reach = Math.max(2, TINT_STEPS * points.spacing(frame));
  return picture(view, (ctx) => drawCells(ctx, points.result, frame, { color, reach }));
}
