// The layers of the picture: the frame, and the masks over it. To add one, list it in {@link createLayers}; panel,
// keyboard and viewer know layers only through the type {@link Layer}.

import { drawLabels } from '../model/library.js';
import type { Segmentation } from '../model/presence.js';

export type Canvas2D = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

/**
 * The data that a layer draws. The context's unit is one clip pixel and its origin the centre of the first one:
 * points are drawn at their coordinates, pictures of the frame from (-0.5, -0.5).
 */
export interface View {
  /** The result; null before there is one. */
  segmentation: Segmentation | null;
  /** The picture of the frame, at clip size or larger. */
  image: CanvasImageSource | null;
  frame: number;
  /** Width of the clip in pixels. */
  width: number;
  height: number;
  /** Clip pixels per CSS pixel; lines scaled by it look the same at every zoom. */
  unit: number;
  visible: (object: number) => boolean;
  /** Returns the mask of the frame with adjusted edges; null if there is none. */
  mask: () => ReturnType<typeof import('../model/library.js').adjustMask> | null;
}

/** A number shown as a slider. */
export interface Setting {
  name: string;
  value: number;
  min: number;
  max: number;
  step: number;
  text: (value: number) => string;
}

export interface Layer {
  id: string;
  name: string;
  key: string;
  about: string;
  isOn: boolean;
  /** Each layer has at least `opacity`. */
  settings: Record<string, Setting>;
  draw: (ctx: Canvas2D, view: View) => void;
}

/** Returns the layers, highest first, as in the panel. */
export function createLayers(): Layer[] {
  return [maskLayer(), imageLayer()];
}

/** Width of the outline in CSS pixels; chosen by eye. */
export const OUTLINE_WIDTH_PX = 1.8;

function maskLayer(): Layer {
  const fill = { ...opacity(0), name: 'Fill' };
  return {
    id: 'masks',
    name: 'Masks',
    key: '1',
    about: 'The outline of each object, in its colour.',
    isOn: true,
    settings: { opacity: opacity(), fill },
    draw(ctx, { mask, unit, visible }) {
      const edged = mask();
      if (!edged) return;
      const masks = { ...edged, numFrames: 1, labels: () => edged.labels };
      const objects = (object: number) => object > 0 && visible(object);
      fromCorner(ctx, () =>
        drawLabels(ctx, masks, 0, { opacity: fill.value, outlineWidth: OUTLINE_WIDTH_PX * unit, objects }),
      );
    },
  };
}

function imageLayer(): Layer {
  return {
    id: 'image',
    name: 'Source image',
    key: '9',
    about: 'The frame itself.',
    isOn: true,
    settings: { opacity: opacity() },
    draw(ctx, view) {
      if (!view.image) return;
      ctx.imageSmoothingQuality = 'high';
      ctx.drawImage(view.image, -0.5, -0.5, view.width, view.height);
    },
  };
}

/** @param value in 0..1 */
function opacity(value = 1): Setting {
  return { name: 'Opacity', value, min: 0, max: 1, step: 0.05, text: (v) => `${Math.round(v * 100)}%` };
}

/**
 * Draws all layers that are on, lowest first.
 * @param ctx already scaled to clip pixels
 */
export function drawLayers(ctx: Canvas2D, layers: Layer[], view: View) {
  for (const layer of layers.filter(({ isOn }) => isOn).reverse()) {
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

/** Draws with the origin of the package's functions: the upper left corner of the frame. */
export function fromCorner(ctx: Canvas2D, draw: () => void) {
  ctx.save();
  ctx.translate(-0.5, -0.5);
  draw();
  ctx.restore();
}
