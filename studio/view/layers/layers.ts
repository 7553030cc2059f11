// The registry of layers. A layer is a value of type {@link Layer}; to add one, write its file and list it in
// {@link createLayers}. Panel, keyboard and viewer know layers only through this type.

import { imageLayer, maskLayer } from './masks.js';
import { boundaryLayer, contourLayer, superpixelLayer } from './frame.js';
import { stillLayer } from './still.js';
import type { Canvas2D, Layer, View } from './layer.js';

/** Returns the layers, in the order of the panel. */
export function createLayers(): Layer[] {
  return [maskLayer(), superpixelLayer(), contourLayer(), boundaryLayer(), stillLayer(), imageLayer()];
}

/**
 * Draws all layers that are on, lowest first.
 * @param ctx already scaled to clip pixels
 */
export function drawLayers(ctx: Canvas2D, layers: Layer[], view: View) {
  for (const layer of layers.filter(({ on }) => on).sort((a, b) => a.z - b.z)) {
    const alpha = layer.settings.opacity.value;
    if (alpha >= 1) layer.draw(ctx, view);
    else if (alpha > 0) drawFaded(ctx, layer, view, alpha);
  }
}

/** Strokes of one layer overlap, so the layer is drawn aside and laid over the picture as a whole. */
function drawFaded(ctx: Canvas2D, layer: Layer, view: View, alpha: number) {
  const aside = new OffscreenCanvas(ctx.canvas.width, ctx.canvas.height);
  const asideCtx = aside.getContext('2d')!;
  asideCtx.setTransform(ctx.getTransform());
  layer.draw(asideCtx, view);
  ctx.save();
  ctx.resetTransform();
  ctx.globalAlpha = alpha;
  ctx.drawImage(aside, 0, 0);
  ctx.restore();
}
