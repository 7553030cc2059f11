/** What stands out by its motion: saliency of pixels and trajectories, and the foreground. @module */

import { drawSaliency, drawTrajectories } from '../library.js';
import { h, key } from '../dom.js';
import { Fetched, picture, valueAt } from './fetched.js';
import { fromCorner, opacity, toggle } from './layer.js';
import { markerSize, trailLength } from './trajectories.js';
import { heatColor, CUT_RED, FAINT } from '../result/palette.js';
import { NOTHING, count } from '../words.js';

/** Points are drawn in this many groups of like saliency, because a fill for each is slow. */
const GRADES = 24;

/** Size of the legend's ramp in CSS pixels. */
const RAMP = { width: 120, height: 10 };

/** @returns {import('./layer.js').Layer} */
export function saliencyLayer() {
  const heat = { ...opacity(0.75), name: 'Pixels' };
  const shown = toggle('Trajectories', true);
  const context = toggle('Trajectories in context (s̄)', true);
  const maps = new Fetched('saliencyMap', (map) => ({
    map,
    canvas: picture(map, (ctx) => drawSaliency(ctx, { ...map, scaleX: 1, scaleY: 1 })),
  }));
  return {
    id: 'saliency',
    name: 'Saliency',
    key: 's',
    only: 'clip',
    about: 'How much the motion of a pixel, or of a trajectory in all its life, stands out against what surrounds it.',
    z: 22,
    on: false,
    settings: { opacity: opacity(), heat, shown, context },
    legend: () => [h('span', { class: 'key' }, '0', ramp(), '1')],
    missing: ({ points }) => (points && !points.result.saliency ? NOTHING.motion : ''),
    reset: () => maps.reset(),
    draw(ctx, view) {
      if (!view.points?.result.saliency) return;
      const known = maps.get(view, view.frame);
      if (known) {
        ctx.globalAlpha = heat.value;
        ctx.drawImage(known.canvas, -0.5, -0.5, view.width, view.height);
        ctx.globalAlpha = 1;
      }
      const { inContext, ofPoints } = view.points.result.saliency;
      if (shown.value > 0) drawPoints(ctx, view, context.value > 0 ? inContext : ofPoints);
    },
    readout(view, spot) {
      const { map } = maps.get(view, view.frame) ?? {};
      const here = map && valueAt(map, map.saliency, view, spot);
      const words = here === undefined ? [] : [`saliency ${here.toFixed(2)}`];
      const { ofPoints, inContext } = view.points?.result.saliency ?? {};
      const { trajectory } = spot;
      if (trajectory >= 0 && ofPoints && inContext) {
        const [own, around] = [ofPoints[trajectory].toFixed(2), inContext[trajectory].toFixed(2)];
        words.push(`trajectory’s ${own}, in context ${around}`);
      }
      return words.join(', ');
    },
  };
}

/**
 * @param {import('./layer.js').Canvas2D} ctx
 * @param {import('./layer.js').View} view
 * @param {Float32Array} saliency of each trajectory
 */
function drawPoints(ctx, view, saliency) {
  const points = /** @type {import('../result/points.js').Points} */ (view.points);
  const grade = (/** @type {number} */ i) => Math.min(GRADES - 1, Math.floor(saliency[i] * GRADES));
  const rgba = new Uint8ClampedArray(4);
  const colors = Array.from({ length: GRADES }, (_, k) => {
    heatColor((k + 0.5) / GRADES, rgba);
    return `rgb(${rgba[0]} ${rgba[1]} ${rgba[2]})`;
  });
  const options = {
    color: (/** @type {number} */ i) => colors[grade(i)],
    objects: view.visible,
    tail: 0,
    ...markerSize(view),
  };
  fromCorner(ctx, () => drawTrajectories(ctx, points.result, view.frame, options));
}

/** @returns {HTMLCanvasElement} the legend: colours from 0 to 1 */
function ramp() {
  const { width, height } = RAMP;
  const image = new ImageData(width, height);
  for (let p = 0; p < width * height; p++) heatColor((p % width) / (width - 1), image.data, 4 * p);
  const canvas = h('canvas', {
    class: 'ramp',
    width,
    height,
    role: 'img',
    'aria-label': 'Colours of saliency, dark for none to bright for most',
  });
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}

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
        counted = `foreground, ${count(those)} of ${count(foreground.length)}`;
        layer.changed?.();
      }
      const { radius, width } = markerSize(view);
      const draw = (/** @type {import('../library.js').DrawTrajectoriesOptions} */ options) =>
        drawTrajectories(ctx, points.result, view.frame, { objects: view.visible, width, ...options });
      fromCorner(ctx, () => {
        draw({ which: (i) => !foreground[i], color: FAINT, radius: FAINT_SIZE * radius, rim: false, tail: 0 });
        draw({ which: (i) => foreground[i] === 1, color: CUT_RED, radius, tail: trail.value });
      });
    },
    readout({ points }, { trajectory }) {
      const { foreground } = points?.result.saliency ?? {};
      if (!foreground || trajectory < 0) return '';
      return foreground[trajectory] ? 'foreground' : 'not foreground';
    },
  };
  return layer;
}
