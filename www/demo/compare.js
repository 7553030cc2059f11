/** The original beside the result, or one over the other with a border that can be moved. @module */

import { byId } from './dom.js';

/** @typedef {'overlay' | 'beside' | 'slider'} View */

/** @type {View[]} */
const VIEWS = ['overlay', 'beside', 'slider'];

/** Narrower windows have no room for two pictures side by side: one lies above the other. */
const NARROW = matchMedia('(max-width: 599px)');

export class Compare {
  /** @param {() => void} onChange called when the pictures have another size, or another is to be drawn */
  constructor(onChange) {
    this.onChange = onChange;
    this.box = byId('screen');
    this.canvas = /** @type {HTMLCanvasElement} */ (byId('original'));
    this.split = /** @type {HTMLInputElement} */ (byId('split'));
    /** @type {View} */
    this.view = 'overlay';
    this.aspect = 16 / 9;
    for (const radio of this.radios) radio.addEventListener('change', () => this.choose(/** @type {View} */ (radio.value)));
    this.split.addEventListener('input', () => this.showSplit());
    NARROW.addEventListener('change', () => this.setAspect(this.aspect));
    this.showSplit();
  }

  /** @returns {HTMLInputElement[]} */
  get radios() {
    return [...byId('views').querySelectorAll('input')];
  }

  /** @param {View} view */
  choose(view) {
    this.view = view;
    this.box.dataset.view = view;
    this.split.hidden = view !== 'slider';
    for (const radio of this.radios) radio.checked = radio.value === view;
    this.setAspect(this.aspect);
    this.onChange();
  }

  /** The next view, for the keyboard. */
  next() {
    this.choose(VIEWS[(VIEWS.indexOf(this.view) + 1) % VIEWS.length]);
  }

  /** @param {number} aspect width of the clip over its height */
  setAspect(aspect) {
    this.aspect = aspect;
    const two = this.view === 'beside' ? (NARROW.matches ? 0.5 : 2) : 1;
    this.box.parentElement?.style.setProperty('--aspect', String(aspect * two));
  }

  showSplit() {
    const share = Number(this.split.value) / 100;
    this.box.style.setProperty('--split', String(share));
    this.split.setAttribute('aria-valuetext', `Original up to ${this.split.value} %`);
  }

  /**
   * Draws the frame as it came.
   *
   * @param {CanvasImageSource | null} image
   * @param {HTMLCanvasElement} like the canvas of the result, whose size it takes
   */
  draw(image, like) {
    if (this.view === 'overlay') return;
    const { canvas, box } = this;
    if (canvas.width !== like.width || canvas.height !== like.height) Object.assign(canvas, { width: like.width, height: like.height });
    for (const side of /** @type {const} */ (['width', 'height'])) {
      canvas.style[side] = like.style[side];
      box.style.setProperty(`--${side}`, like.style[side]);
    }
    const ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    ctx.imageSmoothingQuality = 'high';
    if (image) ctx.drawImage(image, 0, 0, canvas.width, canvas.height);
  }
}
