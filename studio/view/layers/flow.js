/** Optical flow in the colours of a wheel; fields are fetched when they are first looked at. @module */

import { drawFlow } from '../library.js';
import { h } from '../dom.js';
import { Fetched, picture } from './fetched.js';
import { opacity } from './layer.js';
import { flowColor } from '../result/palette.js';
import { quantile } from '../result/points.js';

const WHEEL_PX = 56;

/** @returns {import('./layer.js').Layer} */
export function flowLayer() {
  let scale = 0;
  const pictures = new Fetched('flow', (flow) => picture(flow, (ctx) => drawFlow(ctx, flow, { scale })));
  /** @type {import('./layer.js').Layer} */
  const layer = {
    id: 'flow',
    name: 'Optical flow',
    key: '8',
    only: 'clip',
    about: 'Where each pixel goes in the next frame; computed when first shown.',
    z: 10,
    on: false,
    settings: { opacity: opacity(0.9) },
    legend: () => [
      wheel(),
      h(
        'span',
        { class: 'key-text' },
        'Hue: direction. White: no motion.',
        h('br'),
        scale > 0 ? `Full colour: ${scale.toFixed(1)} px per frame.` : 'Full colour: fast.',
      ),
    ],
    reset() {
      pictures.reset();
      scale = 0;
    },
    draw(ctx, view) {
      if (!view.points || view.points.result.numFrames < 2) return;
      if (scale === 0) {
        scale = motionScale(view.points.result);
        layer.changed?.();
      }
      // The last frame has no next one; it shows the motion that led to it.
      const t = Math.min(view.frame, view.points.result.numFrames - 2);
      const known = pictures.get(view, t);
      if (known) ctx.drawImage(known, -0.5, -0.5, view.width, view.height);
    },
  };
  return layer;
}

/**
 * @param {import('../result/points.js').Result} result
 * @returns {number} motion that gets full colour: 92 % of the trajectories' steps are slower
 */
function motionScale(result) {
  const { count, offset, x, y } = result.trajectories;
  const steps = [];
  for (let i = 0; i < count; i++) {
    for (let k = offset[i]; k + 1 < offset[i + 1]; k += 3) steps.push(Math.hypot(x[k + 1] - x[k], y[k + 1] - y[k]));
  }
  return Math.max(0.5, quantile(steps, 0.92));
}

/** @returns {HTMLCanvasElement} the legend's wheel: motion from its centre outwards has the colour there */
function wheel() {
  const size = 2 * WHEEL_PX;
  const image = new ImageData(size, size);
  const radius = size / 2;
  for (let y = 0; y < size; y++) {
    for (let x = 0; x < size; x++) {
      const at = 4 * (y * size + x);
      const u = x + 0.5 - radius;
      const v = y + 0.5 - radius;
      flowColor(u, v, radius, image.data, at);
      image.data[at + 3] = 255 * Math.min(1, Math.max(0, radius - Math.hypot(u, v)));
    }
  }
  const canvas = h('canvas', {
    class: 'wheel',
    width: size,
    height: size,
    role: 'img',
    'aria-label': 'Colour wheel of motion',
  });
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  return canvas;
}
