// The registry of layers. A layer is a value of type {@link Layer}; to add one, write its file and list it in
// {@link createLayers}. Panel, keyboard and viewer know layers only through this type.

import { imageLayer, maskLayer } from './mask-layers.js';
import { boundaryLayer, contourLayer, superpixelLayer } from './boundary-layers.js';
import { stillLayer } from './embedding-layer.js';
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
  for (const layer of layers.filter(({ isOn }) => isOn).sort((a, b) => a.z - b.z)) {
    const alpha = layer.settings.opacity.value;
    if (alpha >= 1) layer.draw(ctx, view);
    else if (alpha > 0) drawFaded(ctx, layer, view, alpha);
  }
}

/** Draws a layer into a buffer first, as its strokes overlap. */
function drawFaded(ctx: Canvas2D, layer: Layer, view: View, alpha: number) {
  const buffer = new OffscreenCanvas(ctx.canvas.width, ctx.canvas.height);
  const bufferCtx = buffer.getContext('2d')!;
  bufferCtx.setTransform(ctx.getTransform());
  layer.draw(bufferCtx, view);
  ctx.save();
  ctx.resetTransform();
  ctx.globalAlpha = alpha;
  ctx.drawImage(buffer, 0, 0);
  ctx.restore();
}
