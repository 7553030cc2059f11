// What a layer of the viewer is, and what it may look at.

import type { Answers, Spot } from '../../model/answers.js';
import type { Points } from '../../model/points.js';

export type Canvas2D = CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;

/**
 * What a layer may look at while it draws. The context's unit is one pixel of the clip and its origin the centre of the
 * first one: a point of the result is drawn at its own coordinates, a picture of the frame from (-0.5, -0.5).
 */
export interface View {
  /** The result by frame; null before there is one. */
  points: Points | null;
  /** The frame itself, at clip size or larger. */
  image: CanvasImageSource | null;
  frame: number;
  /** Of the clip in pixels. */
  width: number;
  height: number;
  /** Clip pixels in one CSS pixel: line widths times this look the same at every zoom. */
  unit: number;
  visible: (object: number) => boolean;
  /** Of the frame, its edges as they are wanted; null where there is none. */
  mask: () => ReturnType<typeof import('../../model/library.js').adjustMask> | null;
  answers: Answers;
  /** Asks for another `draw`, when something that was missing has come. */
  redraw: () => void;
}

/** A number that the user may change, shown as a slider, as a switch, or as a list of names. */
export interface Setting {
  name: string;
  value: number;
  min: number;
  max: number;
  step: number;
  text: (value: number) => string;
  /** It is 0 or 1. */
  toggle?: boolean;
  /** It is the place of one of these names. */
  choices?: string[];
}

export interface Layer {
  id: string;
  name: string;
  /** On the keyboard; of layers that share one only one can be there at a time. */
  key: string;
  /** For which kind of source it is there; both if not said. */
  only?: 'clip' | 'still';
  /** One sentence on what the layer shows. */
  about: string;
  /** Layers with larger z are drawn over those with smaller. */
  z: number;
  on: boolean;
  /** Each layer has at least `opacity`. */
  settings: Record<string, Setting>;
  legend: () => Node[];
  draw: (ctx: Canvas2D, view: View) => void;
  /** Words about a place; empty for none. */
  readout?: (view: View, spot: Spot) => string;
  /** Forgets everything about the last result. */
  reset?: () => void;
}

/** @param value in 0..1 */
export function opacity(value = 1): Setting {
  return { name: 'Opacity', value, min: 0, max: 1, step: 0.05, text: (v) => `${Math.round(v * 100)} %` };
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

/**
 * @param choices the first is chosen
 * @param value or the one at this place
 */
export function choice(name: string, choices: string[], value = 0): Setting {
  return { name, value, min: 0, max: choices.length - 1, step: 1, text: (v) => choices[v], choices };
}

/**
 * Draws as the package's helpers do, whose origin is the frame's upper left corner and not the centre of its first
 * pixel.
 */
export function fromCorner(ctx: Canvas2D, draw: () => void) {
  ctx.save();
  ctx.translate(-0.5, -0.5);
  draw();
  ctx.restore();
}
