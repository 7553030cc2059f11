// Zoom and pan by wheel, touch, keys and buttons; full screen.

import { byId } from '../dom.js';
import { SCALE_STEP } from '../../model/zoom.js';
import type { Page } from '../page.js';
import type { Viewer } from '../viewer.js';

/** Scroll distance of a wheel notch, in CSS pixels, as in Chromium. */
export const NOTCH_PX = 100;

/** Height of a scrolled line, in CSS pixels: three are a notch. */
const LINE_PX = 33;

/** Shorter drags are clicks, in CSS pixels; chosen by eye. */
export const CLICK_PX = 4;

/** Distance of an arrow key, as a share of the visible part; chosen by eye. */
const PAN_SHARE = 0.1;

/** Narrow windows, where the wheel scrolls the page unless Ctrl is held. */
const NARROW = matchMedia('(max-width: 899px)');

export function zoomPanel({ store, viewer, keys }: Pick<Page, 'store' | 'viewer' | 'keys'>) {
  const pane = new ZoomPanel(viewer);
  const enlarge = (factor: number) => viewer.zoomTo(viewer.zoom.scale * factor, 0.5, 0.5);
  keys.on('+', () => enlarge(SCALE_STEP));
  keys.on('=', () => enlarge(SCALE_STEP));
  keys.on('-', () => enlarge(1 / SCALE_STEP));
  keys.on('0', () => viewer.zoomTo(1, 0.5, 0.5));
  keys.on('w', () => pane.toggleFullScreen());
  for (const [key, u, v] of [
    ['ArrowLeft', PAN_SHARE, 0],
    ['ArrowRight', -PAN_SHARE, 0],
    ['ArrowUp', 0, PAN_SHARE],
    ['ArrowDown', 0, -PAN_SHARE],
  ] as [string, number, number][])
    keys.on(
      `Shift+${key}`,
      () => viewer.pan(u, v),
      () => viewer.zoom.scale > 1,
    );
  byId('zoom-in').addEventListener('click', () => enlarge(SCALE_STEP));
  byId('zoom-out').addEventListener('click', () => enlarge(1 / SCALE_STEP));
  byId('zoom-fit').addEventListener('click', () => viewer.zoomTo(1, 0.5, 0.5));
  byId('fill-screen').addEventListener('click', () => pane.toggleFullScreen());
  byId('fill-screen').hidden = !document.fullscreenEnabled;
  document.addEventListener('fullscreenchange', () =>
    byId('fill-screen').setAttribute('aria-pressed', String(document.fullscreenElement !== null)),
  );
  viewer.onZoom(({ scale }) => {
    byId('zoom-fit').textContent = `${Math.round(100 * scale)}%`;
    byId<HTMLButtonElement>('zoom-out').disabled = scale === 1;
    byId('screen').toggleAttribute('data-zoomed', scale > 1);
  });
  store.watch(['source'], () => viewer.zoomTo(1, 0.5, 0.5));
}

/** Returns the scrolled distance in CSS pixels; it is positive downwards. */
export function wheelDistance({ deltaMode, deltaY }: WheelEvent): number {
  return deltaMode === WheelEvent.DOM_DELTA_PIXEL ? deltaY : deltaY * LINE_PX;
}

class ZoomPanel {
  /** Last position of a drag. */
  drag: { x: number; y: number; moved: boolean } | null = null;
  /** Distance and centre of two fingers, in CSS pixels of the canvas. */
  pinch: { distance: number; x: number; y: number } | null = null;

  constructor(readonly viewer: Viewer) {
    const { canvas } = viewer;
    canvas.addEventListener('wheel', (event) => this.onWheel(event), { passive: false });
    canvas.addEventListener('pointerdown', (event) => this.begin(event));
    canvas.addEventListener('pointermove', (event) => this.pull(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => this.end());
    // A drag is not a click on an object.
    canvas.addEventListener('click', (event) => this.drag?.moved && event.stopImmediatePropagation(), true);
    for (const name of ['touchstart', 'touchmove'] as const)
      canvas.addEventListener(name, (event) => this.touch(event), { passive: false });
    for (const end of ['touchend', 'touchcancel']) canvas.addEventListener(end, () => (this.pinch = null));
  }

  onWheel(event: WheelEvent) {
    if (NARROW.matches && !event.ctrlKey) return;
    event.preventDefault();
    // Pinching a touchpad sends small wheel steps with Ctrl.
    const notches = -wheelDistance(event) / (event.ctrlKey ? NOTCH_PX / 4 : NOTCH_PX);
    const { clientWidth, clientHeight } = this.viewer.canvas;
    this.viewer.zoomTo(
      this.viewer.zoom.scale * SCALE_STEP ** Math.max(-4, Math.min(4, notches)),
      event.offsetX / clientWidth,
      event.offsetY / clientHeight,
    );
  }

  begin(event: PointerEvent) {
    this.drag = null;
    const { canvas, zoom } = this.viewer;
    const isPainting = canvas.classList.contains('is-painting');
    if (zoom.scale === 1 || !(event.button === 1 || (event.button === 0 && !isPainting))) return;
    if (event.button === 1) event.preventDefault();
    this.drag = { x: event.clientX, y: event.clientY, moved: false };
    canvas.setPointerCapture(event.pointerId);
  }

  pull({ buttons, clientX, clientY }: PointerEvent) {
    const { drag, pinch, viewer } = this;
    if (!drag || pinch || buttons === 0) return;
    const [x, y] = [clientX - drag.x, clientY - drag.y];
    if (!drag.moved && Math.hypot(x, y) < CLICK_PX) return;
    Object.assign(drag, { x: clientX, y: clientY, moved: true });
    viewer.pan(x / viewer.canvas.clientWidth, y / viewer.canvas.clientHeight);
  }

  /** Ends a drag after its click event. */
  end() {
    setTimeout(() => (this.drag = null));
  }

  touch(event: TouchEvent) {
    if (event.touches.length !== 2) return;
    event.preventDefault();
    const { canvas, zoom } = this.viewer;
    const box = canvas.getBoundingClientRect();
    const [a, b] = event.touches;
    const now = {
      distance: Math.max(1, Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY)),
      x: (a.clientX + b.clientX) / 2 - box.left,
      y: (a.clientY + b.clientY) / 2 - box.top,
    };
    const lastPinch = this.pinch;
    this.pinch = now;
    if (!lastPinch) return;
    this.viewer.pan((now.x - lastPinch.x) / box.width, (now.y - lastPinch.y) / box.height);
    this.viewer.zoomTo((zoom.scale * now.distance) / lastPinch.distance, now.x / box.width, now.y / box.height);
  }

  toggleFullScreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else
      byId('stage')
        .requestFullscreen?.()
        .catch(() => {});
  }
}
