/** The original beside the result, or one over the other with a border that can be moved. @module */

import { byId } from '../dom.js';
import { say } from '../language.js';

/** @typedef {'overlay' | 'beside' | 'slider' | 'cutout'} View */

/** @type {View[]} */
const VIEWS = ['overlay', 'beside', 'slider', 'cutout'];

/** Narrower windows have no room for two pictures side by side: one lies above the other. */
const NARROW = matchMedia('(max-width: 599px)');

/** @param {Pick<import('./panels.js').Page, 'keys' | 'viewer'>} page */
export function comparePanel({ keys, viewer }) {
  keys.on('v', () => viewer.compare.next());
}

export class Compare {
  /** @param {import('../store.js').Store} store */
  constructor(store) {
    this.store = store;
    this.box = byId('screen');
    this.canvas = /** @type {HTMLCanvasElement} */ (byId('original'));
    this.split = /** @type {HTMLInputElement} */ (byId('split'));
    /** @type {HTMLInputElement[]} */
    this.radios = [...byId('views').querySelectorAll('input')];
    for (const radio of this.radios)
      radio.addEventListener('change', () => store.set({ view: /** @type {View} */ (radio.value) }));
    this.split.addEventListener('input', () => store.set({ split: Number(this.split.value) }));
    NARROW.addEventListener('change', () => this.showShape());
    store.watch(['view'], ({ view }) => this.showView(view));
    store.watch(['view', 'picture'], () => this.showShape());
    store.watch(['split'], ({ split }) => this.showSplit(split));
  }

  /** @param {View} view */
  showView(view) {
    this.box.dataset.view = view;
    this.split.hidden = view !== 'slider';
    for (const radio of this.radios) radio.checked = radio.value === view;
  }

  /** The next view, for the keyboard. */
  next() {
    const { view } = this.store.state;
    this.store.set({ view: VIEWS[(VIEWS.indexOf(view) + 1) % VIEWS.length] });
  }

  /** The screen has the shape of one picture, or of two. */
  showShape() {
    const { view, picture } = this.store.state;
    const two = view === 'beside' ? (NARROW.matches ? 0.5 : 2) : 1;
    this.box.parentElement?.style.setProperty('--aspect', String((picture.width / picture.height) * two));
  }

  /** @param {number} percent */
  showSplit(percent) {
    this.split.value = String(percent);
    this.box.style.setProperty('--split', String(percent / 100));
    this.split.setAttribute('aria-valuetext', say`Original up to ${percent} %`);
  }

  /**
   * Draws the frame as it came.
   *
   * @param {CanvasImageSource | null} image
   * @param {HTMLCanvasElement} like the canvas of the result, whose size it takes
   * @param {import('../zoom.js').Zoom} zoom
   */
  draw(image, like, { by, x, y }) {
    if (!['beside', 'slider'].includes(this.store.state.view)) return;
    const { canvas, box } = this;
    if (canvas.width !== like.width || canvas.height !== like.height)
      Object.assign(canvas, { width: like.width, height: like.height });
    for (const side of /** @type {const} */ (['width', 'height'])) {
      canvas.style[side] = like.style[side];
      box.style.setProperty(`--${side}`, like.style[side]);
    }
    const ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    ctx.imageSmoothingQuality = 'high';
    const { width, height } = canvas;
    if (image) ctx.drawImage(image, -x * by * width, -y * by * height, by * width, by * height);
  }
}
