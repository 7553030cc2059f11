/**
 * The registry of layers. A layer is a value of type {@link Layer}; to add one, write its file and list it in
 * {@link createLayers}. Panel, keyboard and viewer know layers only through this type.
 * @module
 */

import { boundaryLayer } from './draw-boundaries.js';
import { componentLayer } from './draw-components.js';
import { contourLayer } from './draw-contours.js';
import { discontinuityLayer } from './draw-discontinuities.js';
import { embeddingLayer } from './draw-embedding.js';
import { flowLayer } from './draw-flow.js';
import { foregroundLayer } from './draw-foreground.js';
import { imageLayer } from './draw-image.js';
import { maskLayer } from './draw-masks.js';
import { saliencyLayer } from './draw-saliency.js';
import { stillLayer } from './draw-still.js';
import { superpixelLayer } from './draw-superpixels.js';
import { trajectoryLayer } from './draw-trajectories.js';
import { NOTHING } from './words.js';

/** @typedef {import('./layer.js').Layer} Layer */
/** @typedef {import('./layer.js').View} View */

/** @returns {Layer[]} in the order of the panel */
export function createLayers() {
  return [
    maskLayer(),
    trajectoryLayer(),
    superpixelLayer(),
    contourLayer(),
    boundaryLayer(),
    discontinuityLayer(),
    stillLayer(),
    embeddingLayer(),
    saliencyLayer(),
    foregroundLayer(),
    componentLayer(),
    flowLayer(),
    imageLayer(),
  ];
}

/** What a clip that was taken window by window can show. */
const OF_WINDOWS = ['masks', 'superpixels', 'contours', 'boundaries', 'image'];

/**
 * @param {Layer} layer
 * @param {View} view
 * @returns {string} why there is nothing to show; empty where there is
 */
export function missingOf(layer, view) {
  if (view.windows && layer.id === 'trajectories') return view.points?.result.trajectories.count ? '' : NOTHING.joined;
  if (view.windows && !OF_WINDOWS.includes(layer.id)) return NOTHING.windows;
  return layer.missing?.(view) ?? '';
}

/**
 * Draws all layers that are on, lowest first.
 *
 * @param {CanvasRenderingContext2D} ctx already scaled to clip pixels
 * @param {Layer[]} layers
 * @param {View} view
 */
export function drawLayers(ctx, layers, view) {
  const order = layers.filter((layer) => layer.on && !missingOf(layer, view)).sort((a, b) => a.z - b.z);
  for (const layer of order) {
    const alpha = layer.settings.opacity.value;
    if (alpha >= 1) layer.draw(ctx, view);
    else if (alpha > 0) drawFaded(ctx, layer, view, alpha);
  }
}

/**
 * Strokes of one layer overlap, so the layer is drawn aside and laid over the picture as a whole.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {Layer} layer
 * @param {View} view
 * @param {number} alpha
 */
function drawFaded(ctx, layer, view, alpha) {
  const aside = new OffscreenCanvas(ctx.canvas.width, ctx.canvas.height);
  const asideCtx = /** @type {any} */ (aside.getContext('2d'));
  asideCtx.setTransform(ctx.getTransform());
  layer.draw(asideCtx, view);
  ctx.save();
  ctx.resetTransform();
  ctx.globalAlpha = alpha;
  ctx.drawImage(aside, 0, 0);
  ctx.restore();
}
