// With the tool Pick, a drag from one object to another joins them.

import { isMultiSelect } from '../dom.js';
import { CLICK_PX } from './zoom.js';
import type { CanvasPlace, Viewer } from '../viewer.js';
import type { View } from '../layers.js';

/** Radius of the ends of the line, in CSS pixels; chosen by eye. */
const END_RADIUS_PX = 4;

interface Host {
  isOn: () => boolean;
  /** Joins the second object with the first. */
  join: (into: number, other: number) => void;
}

/** A drag: its start in CSS pixels and its ends in clip pixels, the pressed object and that under the pointer. */
type Drag = {
  start: CanvasPlace;
  from: [x: number, y: number];
  to: [x: number, y: number];
  object: number;
  target: number;
  isMoved: boolean;
};

export class JoinDrag {
  drag: Drag | null = null;
  /** True until the click event of a drag. */
  endsInClick = false;

  constructor(
    readonly viewer: Viewer,
    readonly host: Host,
  ) {
    const { canvas } = viewer;
    // Before the zoom, which pans.
    canvas.addEventListener('pointerdown', (event) => this.press(event), { capture: true });
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', () => this.release());
    canvas.addEventListener('pointercancel', () => this.end());
    canvas.addEventListener('click', (event) => this.endsInClick && event.stopImmediatePropagation(), {
      capture: true,
    });
    // A finger would scroll the page.
    canvas.addEventListener('touchmove', (event) => this.drag && event.preventDefault(), { passive: false });
  }

  /** The objects that would be joined, while there are two. */
  get marked(): number[] {
    const { drag } = this;
    return drag?.isMoved && joins(drag) ? [drag.object, drag.target] : [];
  }

  press(event: PointerEvent) {
    this.end();
    if (!event.isPrimary || event.button !== 0 || isMultiSelect(event) || !this.host.isOn()) return;
    const { object } = this.viewer.spotAt(event);
    if (object < 1) return;
    event.stopImmediatePropagation();
    this.viewer.canvas.setPointerCapture(event.pointerId);
    const place = this.viewer.placeAt(event);
    const { offsetX, offsetY } = event;
    this.drag = { start: { offsetX, offsetY }, from: place, to: place, object, target: object, isMoved: false };
  }

  move(event: PointerEvent) {
    const { drag, viewer } = this;
    if (!drag) return;
    const { start } = drag;
    drag.isMoved ||= Math.hypot(event.offsetX - start.offsetX, event.offsetY - start.offsetY) > CLICK_PX;
    drag.to = viewer.placeAt(event);
    drag.target = viewer.spotAt(event).object;
    viewer.redraw();
  }

  release() {
    const { drag, host } = this;
    this.end();
    if (!drag?.isMoved || drag.target === drag.object) return;
    this.endsInClick = true;
    setTimeout(() => (this.endsInClick = false));
    if (joins(drag) && host.isOn()) host.join(drag.object, drag.target);
  }

  end() {
    this.drag = null;
    this.viewer.redraw();
  }

  /** @param ctx scaled to clip pixels */
  draw(ctx: CanvasRenderingContext2D, { unit }: View) {
    const { drag } = this;
    if (!drag?.isMoved) return;
    ctx.lineCap = 'round';
    for (const [style, width] of [
      ['rgb(0 0 0 / 0.7)', 5],
      ['#fff', 2.5],
    ] as const) {
      ctx.strokeStyle = ctx.fillStyle = style;
      ctx.lineWidth = width * unit;
      ctx.beginPath();
      ctx.moveTo(...drag.from);
      ctx.lineTo(...drag.to);
      ctx.stroke();
      for (const end of [drag.from, drag.to]) {
        ctx.beginPath();
        ctx.arc(...end, (END_RADIUS_PX + width / 2 - 1) * unit, 0, 2 * Math.PI);
        ctx.fill();
      }
    }
  }
}

function joins({ object, target }: Drag): boolean {
  return target > 0 && target !== object;
}
