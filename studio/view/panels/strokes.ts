// Strokes on the canvas: of the brush and the eraser, or lines over what is one thing and what is not.

import { TOUCH } from '../dom.js';
import type { BrushTool } from '../../model/brush.js';
import type { Stroke } from '../../model/corrections.js';
import type { View } from '../layers/layer.js';
import type { Viewer } from '../viewer.js';

export const BRUSH_HELP = {
  paint: 'Paint what belongs to the object.',
  erase: 'Wipe away what does not belong to the object.',
  add: TOUCH
    ? 'Tap a thing that was missed; a tap beside it adds to it.'
    : 'Click a thing that was missed; a click beside it adds to it, with Alt it takes away.',
};

export function isBrush(tool: string): tool is BrushTool {
  return tool in BRUSH_HELP;
}

/** Half the width of the brush in CSS pixels. */
const BRUSH_PX = 7;

/** Points of a stroke are at least this far apart, in CSS pixels. */
const STEP_PX = 2;

const COLOURS = {
  together: ['#ffffff'],
  apart: ['#ff2b3d', '#ffffff', '#3a45c4', '#ffd400'],
  paint: ['#ffffff'],
  erase: ['#16181d'],
};

type StrokeTool = keyof typeof COLOURS;

export class Strokes {
  list: Stroke[] = [];
  tool: StrokeTool | null = null;
  /** The one under the pointer. */
  current: Stroke | null = null;

  /** @param brush what a stroke of it does at once, and half its width in CSS pixels */
  constructor(
    readonly viewer: Viewer,
    readonly onChange: () => void,
    public brush: { radius: () => number; paint: (stroke: Stroke, tool: 'paint' | 'erase') => void },
  ) {
    const { canvas } = viewer;
    canvas.addEventListener('pointerdown', (event) => this.begin(event));
    canvas.addEventListener('pointermove', (event) => this.extend(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => this.end());
  }

  /** @param tool null paints nothing */
  use(tool: StrokeTool | null) {
    if (tool !== this.tool) this.list = [];
    this.tool = tool;
    this.current = null;
    this.viewer.canvas.classList.toggle('is-painting', tool !== null);
    this.viewer.redraw();
  }

  clear() {
    this.list = [];
    this.current = null;
    this.onChange();
    this.viewer.redraw();
  }

  /** Half the width of a stroke, in CSS pixels. */
  get radius() {
    return this.tool === 'paint' || this.tool === 'erase' ? this.brush.radius() : BRUSH_PX;
  }

  begin(event: PointerEvent) {
    if (!this.tool || event.button !== 0) return;
    const { canvas, view } = this.viewer;
    canvas.setPointerCapture(event.pointerId);
    this.current = { t: view.frame, points: this.at(event), radius: this.radius * view.unit };
    this.viewer.redraw();
  }

  extend(event: PointerEvent) {
    // The brush's tip goes with the pointer.
    if (this.tool === 'paint' || this.tool === 'erase') this.viewer.redraw();
    if (!this.current) return;
    const { points } = this.current;
    const [x, y] = this.at(event);
    const far = Math.hypot(x - points[points.length - 2], y - points[points.length - 1]);
    if (far < STEP_PX * this.viewer.view.unit) return;
    points.push(x, y);
    this.viewer.redraw();
  }

  end() {
    if (!this.current) return;
    const { current, tool } = this;
    this.current = null;
    if (tool === 'paint' || tool === 'erase') {
      this.brush.paint(current, tool);
      return;
    }
    this.list = [...this.list, current];
    this.onChange();
  }

  at(event: PointerEvent): [x: number, y: number] {
    return this.viewer.placeAt(event);
  }

  /** @param ctx scaled to clip pixels */
  draw(ctx: CanvasRenderingContext2D, view: View) {
    const { tool } = this;
    if (!tool) return;
    const all = this.current ? [...this.list, this.current] : this.list;
    ctx.lineCap = 'round';
    ctx.lineJoin = 'round';
    all.forEach(({ t, points, radius }, k) => {
      const colours = COLOURS[tool];
      for (const [style, width] of [
        ['rgb(0 0 0 / 0.7)', 2 * radius + 3 * view.unit],
        [colours[k % colours.length], 2 * radius],
      ] as [string, number][]) {
        // A stroke of another frame is only hinted at.
        ctx.globalAlpha = t === view.frame ? 0.75 : 0.2;
        ctx.strokeStyle = style;
        ctx.lineWidth = width;
        ctx.beginPath();
        ctx.moveTo(points[0], points[1]);
        ctx.lineTo(points[0], points[1]);
        for (let p = 2; p < points.length; p += 2) ctx.lineTo(points[p], points[p + 1]);
        ctx.stroke();
      }
    });
    ctx.globalAlpha = 1;
    if (tool === 'paint' || tool === 'erase') this.drawTip(ctx, view);
  }

  /** How wide the brush is, around the pointer. */
  drawTip(ctx: CanvasRenderingContext2D, view: View) {
    const { pointer } = this.viewer;
    if (!pointer) return;
    for (const [style, width] of [
      ['rgb(0 0 0 / 0.7)', 3],
      ['#fff', 1.5],
    ] as [string, number][]) {
      ctx.strokeStyle = style;
      ctx.lineWidth = width * view.unit;
      ctx.beginPath();
      ctx.arc(...this.viewer.placeAt(pointer), this.radius * view.unit, 0, 2 * Math.PI);
      ctx.stroke();
    }
  }
}
