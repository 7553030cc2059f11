// A crosshair for the keyboard: arrow keys move it over the focused picture, Enter and the space bar apply the tool.

import { objectName } from '../../model/palette.js';
import type { Keys } from '../keyboard.js';
import type { View } from '../layers.js';
import type { CanvasPlace, Viewer } from '../viewer.js';

/** Distances of an arrow key without and with Shift, in CSS pixels; chosen by eye. */
const STEP_PX = 8;
const FINE_STEP_PX = 1;

/** Length of each arm, in CSS pixels; chosen by eye. */
const ARM_PX = 12;

const DIRECTIONS: Record<string, [x: number, y: number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** Actions of the keys. */
interface Host {
  move: (place: CanvasPlace) => void;
  apply: (place: CanvasPlace, event: KeyboardEvent) => void;
  leave: () => void;
}

export class Crosshair {
  /** Its last position; a pointer that moves takes its place. */
  place: CanvasPlace | null = null;

  constructor(
    readonly viewer: Viewer,
    readonly keys: Keys,
    readonly host: Host,
  ) {
    viewer.canvas.addEventListener('keydown', (event) => this.press(event));
    viewer.canvas.addEventListener('blur', () => this.leave());
    viewer.painters.push((ctx, view) => this.draw(ctx, view));
  }

  press(event: KeyboardEvent) {
    // After a click on the picture the keys belong to the page.
    if (!this.keys.tabbed || event.ctrlKey || event.metaKey) return;
    const direction = DIRECTIONS[event.key];
    if (direction) this.move(direction, event.shiftKey ? FINE_STEP_PX : STEP_PX);
    else if (event.key === 'Enter' || event.key === ' ') this.host.apply(this.current, event);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  get current(): CanvasPlace {
    const { canvas, pointer } = this.viewer;
    return pointer ?? { offsetX: canvas.clientWidth / 2, offsetY: canvas.clientHeight / 2 };
  }

  move([x, y]: [x: number, y: number], step: number) {
    const { viewer, current } = this;
    const { clientWidth, clientHeight } = viewer.canvas;
    this.place = {
      offsetX: Math.max(0, Math.min(clientWidth - 1, current.offsetX + step * x)),
      offsetY: Math.max(0, Math.min(clientHeight - 1, current.offsetY + step * y)),
    };
    const before = viewer.store.state.spot.object;
    viewer.movePointer(this.place);
    const { object } = viewer.store.state.spot;
    if (object !== before && object >= 0) viewer.store.set({ announcement: objectName(object) });
    this.host.move(this.place);
    viewer.redraw();
  }

  /** True if the keyboard moves it. */
  get isShown() {
    return this.place !== null && this.place === this.viewer.pointer;
  }

  leave() {
    this.host.leave();
    if (this.isShown) this.viewer.movePointer(null);
    this.viewer.redraw();
  }

  /** @param ctx scaled to clip pixels */
  draw(ctx: CanvasRenderingContext2D, { unit }: View) {
    const { place, viewer } = this;
    if (!place || !this.isShown) return;
    const [x, y] = viewer.placeAt(place);
    const arm = ARM_PX * unit;
    for (const [style, width] of [
      ['rgb(0 0 0 / 0.7)', 3],
      ['#fff', 1.5],
    ] as [string, number][]) {
      ctx.strokeStyle = style;
      ctx.lineWidth = width * unit;
      ctx.beginPath();
      ctx.moveTo(x - arm, y);
      ctx.lineTo(x + arm, y);
      ctx.moveTo(x, y - arm);
      ctx.lineTo(x, y + arm);
      ctx.stroke();
    }
  }
}
