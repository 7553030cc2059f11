// Strokes on the canvas: brush, eraser, and lines that join or split objects.

import { TOUCH } from '../dom.js';
import type { BrushTool } from '../../model/brush.js';
import type { Stroke } from '../../model/corrections.js';
import type { View } from '../layers.js';
import type { CanvasPlace, Viewer } from '../viewer.js';

export const BRUSH_HELP = {
  paint: 'Paint over the object.',
  erase: 'Erase what is not part of the object.',
  add: TOUCH
    ? 'Tap a missing object; tap beside it to extend it.'
    : 'Click to add what is outlined. Scroll or press + − to change its size, Alt to remove it.',
};

export const STROKE_HELP = {
  pick: 'Drag to another object to join them.',
  together: 'Paint over the parts of one object.',
  apart: 'Paint one stroke on each object to separate.',
};

export function isBrush(tool: string): tool is BrushTool {
  return tool in BRUSH_HELP;
}

/** Radius of strokes that join or split, in CSS pixels; chosen by eye. */
const STROKE_RADIUS_PX = 7;

/** Smallest distance between points of a stroke, in CSS pixels; chosen by eye. */
const MIN_POINT_DISTANCE_PX = 2;

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
  /** The stroke being drawn. */
  current: Stroke | null = null;

  /** @param brush applies strokes of the brush at once; radius in CSS pixels */
  constructor(
    readonly viewer: Viewer,
    readonly onChange: () => void,
    public brush: { radius: () => number; paint: (stroke: Stroke, tool: 'paint' | 'erase') => void },
  ) {
    const { canvas } = viewer;
    canvas.addEventListener('pointerdown', (event) => this.press(event));
    canvas.addEventListener('pointermove', (event) => this.extend(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => this.end());
  }

  /** @param tool null to draw nothing */
  selectTool(tool: StrokeTool | null) {
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

  /** Radius of a stroke, in CSS pixels. */
  get radius() {
    return this.tool === 'paint' || this.tool === 'erase' ? this.brush.radius() : STROKE_RADIUS_PX;
  }

  press(event: PointerEvent) {
    if (!this.tool || event.button !== 0) return;
    this.viewer.canvas.setPointerCapture(event.pointerId);
    this.begin(event);
  }

  begin(place: CanvasPlace) {
    const { view } = this.viewer;
    this.current = { t: view.frame, points: this.viewer.placeAt(place), radius: this.radius * view.unit };
    this.viewer.redraw();
  }

  extend(place: CanvasPlace) {
    // The brush outline follows the pointer.
    if (this.tool === 'paint' || this.tool === 'erase') this.viewer.redraw();
    if (!this.current) return;
    const { points } = this.current;
    const [x, y] = this.viewer.placeAt(place);
    const distance = Math.hypot(x - points[points.length - 2], y - points[points.length - 1]);
    if (distance < MIN_POINT_DISTANCE_PX * this.viewer.view.unit) return;
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

  /** @param ctx scaled to clip pixels */
  draw(ctx: CanvasRenderingContext2D, view: View) {
    const { tool } = this;
    if (!tool) return;
    const strokes = this.current ? [...this.list, this.current] : this.list;
    ctx.lineCap = 'round';
    ctx.lineJoin = 'round';
    strokes.forEach(({ t, points, radius }, k) => {
      const colours = COLOURS[tool];
      for (const [style, width] of [
        ['rgb(0 0 0 / 0.7)', 2 * radius + 3 * view.unit],
        [colours[k % colours.length], 2 * radius],
      ] as [string, number][]) {
        // Strokes of other frames are faint.
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

  /** Draws the outline of the brush at the pointer. */
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
