// Looking closer: by wheel, by two fingers, by keys and buttons; moving about; filling the screen.

import { byId } from '../dom.js';
import { STEP } from '../../model/zoom.js';
import type { Page } from '../page.js';
import type { Viewer } from '../viewer.js';

/** Wheels that scroll turn so far for a notch, in CSS pixels. */
const NOTCH = 100;

/** A press that moves by less is a click, in CSS pixels. */
const CLICK_PX = 4;

/** What an arrow key moves, in parts of what is shown. */
const PART = 0.1;

/** In narrow windows the page scrolls: there the wheel is its own, unless a key is held. */
const NARROW = matchMedia('(max-width: 899px)');

export function zoomPanel({ store, viewer, keys }: Pick<Page, 'store' | 'viewer' | 'keys'>) {
  const pane = new ZoomPanel(viewer);
  const enlarge = (by: number) => viewer.enlarge(viewer.zoom.by * by, 0.5, 0.5);
  keys.on('+', () => enlarge(STEP));
  keys.on('=', () => enlarge(STEP));
  keys.on('-', () => enlarge(1 / STEP));
  keys.on('0', () => viewer.enlarge(1, 0.5, 0.5));
  keys.on('w', () => pane.fill());
  for (const [key, u, v] of [
    ['ArrowLeft', PART, 0],
    ['ArrowRight', -PART, 0],
    ['ArrowUp', 0, PART],
    ['ArrowDown', 0, -PART],
  ] as [string, number, number][])
    keys.on(
      `Shift+${key}`,
      () => viewer.move(u, v),
      () => viewer.zoom.by > 1,
    );
  byId('zoom-in').addEventListener('click', () => enlarge(STEP));
  byId('zoom-out').addEventListener('click', () => enlarge(1 / STEP));
  byId('zoom-fit').addEventListener('click', () => viewer.enlarge(1, 0.5, 0.5));
  byId('fill-screen').addEventListener('click', () => pane.fill());
  byId('fill-screen').hidden = !document.fullscreenEnabled;
  document.addEventListener('fullscreenchange', () =>
    byId('fill-screen').setAttribute('aria-pressed', String(document.fullscreenElement !== null)),
  );
  viewer.onZoom(({ by }) => {
    byId('zoom-fit').textContent = `${Math.round(100 * by)}\u00a0%`;
    byId<HTMLButtonElement>('zoom-out').disabled = by === 1;
    byId('screen').toggleAttribute('data-zoomed', by > 1);
  });
  store.watch(['source'], () => viewer.enlarge(1, 0.5, 0.5));
}

class ZoomPanel {
  /** Where a press that moves the picture was last. */
  drag: { x: number; y: number; moved: boolean } | null = null;
  /** Two fingers, in CSS pixels of the canvas. */
  pinch: { apart: number; x: number; y: number } | null = null;

  constructor(readonly viewer: Viewer) {
    const { canvas } = viewer;
    canvas.addEventListener('wheel', (event) => this.turn(event), { passive: false });
    canvas.addEventListener('pointerdown', (event) => this.begin(event));
    canvas.addEventListener('pointermove', (event) => this.pull(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => this.end());
    // What was a movement is no click on an object.
    canvas.addEventListener('click', (event) => this.drag?.moved && event.stopImmediatePropagation(), true);
    for (const name of ['touchstart', 'touchmove'] as const)
      canvas.addEventListener(name, (event) => this.touch(event), { passive: false });
    for (const end of ['touchend', 'touchcancel']) canvas.addEventListener(end, () => (this.pinch = null));
  }

  turn(event: WheelEvent) {
    if (NARROW.matches && !event.ctrlKey) return;
    event.preventDefault();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : event.deltaY * 33;
    // Two fingers on a pad come as a wheel with the control key, in small steps.
    const notches = -pixels / (event.ctrlKey ? NOTCH / 4 : NOTCH);
    const { clientWidth, clientHeight } = this.viewer.canvas;
    this.viewer.enlarge(
      this.viewer.zoom.by * STEP ** Math.max(-4, Math.min(4, notches)),
      event.offsetX / clientWidth,
      event.offsetY / clientHeight,
    );
  }

  begin(event: PointerEvent) {
    this.drag = null;
    const { canvas, zoom } = this.viewer;
    const isPainting = canvas.classList.contains('is-painting');
    if (zoom.by === 1 || !(event.button === 1 || (event.button === 0 && !isPainting))) return;
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
    viewer.move(x / viewer.canvas.clientWidth, y / viewer.canvas.clientHeight);
  }

  /** The click that belongs to a press comes after it. */
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
      apart: Math.max(1, Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY)),
      x: (a.clientX + b.clientX) / 2 - box.left,
      y: (a.clientY + b.clientY) / 2 - box.top,
    };
    const before = this.pinch;
    this.pinch = now;
    if (!before) return;
    this.viewer.move((now.x - before.x) / box.width, (now.y - before.y) / box.height);
    this.viewer.enlarge((zoom.by * now.apart) / before.apart, now.x / box.width, now.y / box.height);
  }

  /** Fills the screen with picture and timeline, or gives it back. */
  fill() {
    if (document.fullscreenElement) document.exitFullscreen();
    else
      byId('stage')
        .requestFullscreen?.()
        .catch(() => {});
  }
}
