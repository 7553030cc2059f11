// The types of layers, their settings and the view that they draw.

import type { FrameDataSource, Spot } from '../../model/frame-data.js';
import type { Segmentation } from '../../model/segmentation.js';

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
  mask: () => ReturnType<typeof import('../../model/library.js').adjustMask> | null;
  frameData: FrameDataSource;
  /** Requests another `draw`, when missing data is loaded. */
  redraw: () => void;
}

/** A number shown as a slider, a switch or a list of names. */
export interface Setting {
  name: string;
  value: number;
  min: number;
  max: number;
  step: number;
  text: (value: number) => string;
  /** True if it is 0 or 1. */
  toggle?: boolean;
  choices?: string[];
}

export interface Layer {
  id: string;
  name: string;
  key: string;
  /** Kind of source that it applies to; both if absent. */
  only?: 'clip' | 'still';
  about: string;
  /** Layers are drawn by increasing z. */
  z: number;
  isOn: boolean;
  /** Each layer has at least `opacity`. */
  settings: Record<string, Setting>;
  legend: () => Node[];
  draw: (ctx: Canvas2D, view: View) => void;
  /** Returns text about a position; empty for none. */
  readout?: (view: View, spot: Spot) => string;
  reset?: () => void;
}

/** @param value in 0..1 */
export function opacity(value = 1): Setting {
  return { name: 'Opacity', value, min: 0, max: 1, step: 0.05, text: (v) => `${Math.round(v * 100)}%` };
}

export function toggle(name: string, on: boolean): Setting {
  return {
    name,
    value: on ? 1 : 0,
    min: 0,
    max: 1,
    step: 1,
    text: (v) => (v > 0 ? 'on' : 'off'),
    toggle: true,
  };
}

/** @param value index of the selected choice */
export function choice(name: string, choices: string[], value = 0): Setting {
  return { name, value, min: 0, max: choices.length - 1, step: 1, text: (v) => choices[v], choices };
}

/** Draws with the origin of the package's functions: the upper left corner of the frame. */
export function fromCorner(ctx: Canvas2D, draw: () => void) {
  ctx.save();
  ctx.translate(-0.5, -0.5);
  draw();
  ctx.restore();
}
