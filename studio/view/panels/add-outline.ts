// The outline of the region that a click with Add would take. The wheel, + and − change its size; with Alt it is removed.

import { Candidates, traceRegion } from '../../model/candidates.js';
import { formatPercent } from '../../model/messages.js';
import { NEW_OBJECT } from '../../model/brush.js';
import { objectColor } from '../../model/palette.js';
import { wheelDistance } from './zoom.js';
import type { Corrections } from '../../model/corrections.js';
import type { Page } from '../page.js';
import type { View } from '../layers.js';

/** Scroll distance of one size, in CSS pixels: half a notch, which some browsers report for one; chosen by eye. */
const SIZE_SCROLL_PX = 50;

/** Opacity of the region's fill; chosen by eye. */
const FILL_OPACITY = 0.3;

interface Host {
  corrector: () => Corrections | null;
  /** The object that a region on the background becomes part of. */
  object: () => number;
  /** Called when another region is outlined, or none. */
  onChange: () => void;
}

export class AddOutline {
  candidates: Candidates;
  isRemoving = false;
  /** Distance scrolled since the last change of size, in CSS pixels. */
  scrolled = 0;
  /** The closed lines of the outlined region, traced once. */
  traced: { pixels: Uint8Array; lines: number[][] } | null = null;

  constructor(
    readonly page: Pick<Page, 'store' | 'viewer' | 'keys'>,
    readonly host: Host,
  ) {
    const { store, viewer, keys } = page;
    const { corrector, onChange } = host;
    this.candidates = new Candidates({ store, corrector, onChange });
    store.watch(['spot', 'isPlaying'], () => this.aim());
    // Before the zoom of the picture.
    viewer.canvas.addEventListener('wheel', (event) => this.scroll(event), { capture: true, passive: false });
    for (const name of ['keydown', 'keyup'] as const) addEventListener(name, (event) => this.holdAlt(event));
    addEventListener('blur', () => this.setRemoving(false));
    viewer.canvas.addEventListener('pointermove', ({ altKey }) => this.setRemoving(altKey));
    for (const [key, by] of [
      ['+', 1],
      ['=', 1],
      ['-', -1],
    ] as const)
      keys.on(
        key,
        () => this.candidates.resize(by),
        () => this.isUnderPointer,
      );
  }

  /** True if the tool is selected and the pointer or the crosshair is on the picture. */
  get isUnderPointer() {
    return this.candidates.isOn && this.page.viewer.pointer !== null;
  }

  aim() {
    const { spot, frame, isPlaying } = this.page.store.state;
    const isPossible = this.candidates.isOn && !isPlaying && spot.object >= 0;
    this.candidates.aimAt(isPossible ? { t: frame, ...spot, isRemoving: this.isRemoving } : null);
  }

  scroll(event: WheelEvent) {
    // With Ctrl the wheel still zooms.
    if (!this.isUnderPointer || event.ctrlKey) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    const distance = -wheelDistance(event);
    this.scrolled = Math.sign(distance) === Math.sign(this.scrolled) ? this.scrolled + distance : distance;
    if (Math.abs(this.scrolled) < SIZE_SCROLL_PX) return;
    this.candidates.resize(this.scrolled > 0 ? 1 : -1);
    this.scrolled = 0;
  }

  holdAlt(event: KeyboardEvent) {
    if (event.key !== 'Alt' || !this.isUnderPointer) return;
    // The browser would open its menu.
    event.preventDefault();
    this.setRemoving(event.type === 'keydown');
  }

  setRemoving(isRemoving: boolean) {
    if (isRemoving === this.isRemoving) return;
    this.isRemoving = isRemoving;
    this.aim();
  }

  /** Returns `Size 2 of 3, 4.1% of the frame`; empty without an outline. */
  get text(): string {
    const { outlined } = this.candidates;
    if (!outlined) return '';
    const { list, at } = outlined;
    const { pixels, area } = list[at];
    return `Size ${at + 1} of ${list.length}, ${formatPercent(area / pixels.length)} of the frame`;
  }

  /** @param ctx scaled to clip pixels */
  draw(ctx: CanvasRenderingContext2D, { frame, width, height, unit }: View) {
    const { outlined } = this.candidates;
    if (outlined?.aim.t !== frame) return;
    const { pixels } = outlined.list[outlined.at];
    if (this.traced?.pixels !== pixels) this.traced = { pixels, lines: traceRegion(pixels, width, height) };
    const { isRemoving, object } = outlined.aim;
    const label = object || this.host.object();
    ctx.beginPath();
    for (const line of this.traced.lines) {
      ctx.moveTo(line[0], line[1]);
      for (let k = 2; k < line.length; k += 2) ctx.lineTo(line[k], line[k + 1]);
      ctx.closePath();
    }
    ctx.globalAlpha = FILL_OPACITY;
    ctx.fillStyle = label === NEW_OBJECT ? '#fff' : objectColor(label);
    if (!isRemoving) ctx.fill('evenodd');
    ctx.globalAlpha = 1;
    ctx.lineJoin = 'round';
    for (const [style, lineWidth, dash] of [
      ['rgb(0 0 0 / 0.7)', 4, []],
      ['#fff', 2, isRemoving ? [6, 4] : []],
    ] as const) {
      ctx.strokeStyle = style;
      ctx.lineWidth = lineWidth * unit;
      ctx.setLineDash(dash.map((length) => length * unit));
      ctx.stroke();
    }
    ctx.setLineDash([]);
  }
}
