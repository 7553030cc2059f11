/**
 * How the result is looked at: over the original, beside it, behind a border that can be moved, or cut out on a
 * ground.
 * @module
 */

import { byId } from '../dom.js';
import { drawCutout } from '../../model/library.js';
import { groundOf } from '../../model/look.js';
import { fromCorner } from '../layers/layer.js';
import { errorPatch } from '../../model/store.js';
import { PageError } from '../../model/words.js';

/** @typedef {import('../../model/look.js').GroundName} GroundName */
/** @typedef {import('../../model/look.js').View} View */

/** @type {View[]} */
const VIEWS = ['overlay', 'beside', 'slider', 'cutout'];

/** Narrower windows have no room for two wide pictures side by side: one lies above the other. */
const NARROW = matchMedia('(max-width: 599px)');

/** @param {Pick<import('../page.js').Page, 'keys' | 'viewer'>} page */
export function comparePanel({ keys, viewer }) {
  keys.on('v', () => viewer.compare.next());
}

export class Compare {
  /** @param {import('../../model/store.js').Store} store */
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
    const stacks = NARROW.matches && picture.width > picture.height;
    const two = view === 'beside' ? (stacks ? 0.5 : 2) : 1;
    this.box.toggleAttribute('data-stacks', stacks);
    this.box.parentElement?.style.setProperty('--aspect', String((picture.width / picture.height) * two));
  }

  /** @param {number} percent */
  showSplit(percent) {
    this.split.value = String(percent);
    this.box.style.setProperty('--split', String(percent / 100));
    this.split.setAttribute('aria-valuetext', `Original up to ${percent} %`);
  }

  /**
   * Draws the frame as it came.
   *
   * @param {CanvasImageSource | null} image
   * @param {HTMLCanvasElement} like the canvas of the result, whose size it takes
   * @param {import('../../model/zoom.js').Zoom} zoom
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

/** @param {Pick<import('../page.js').Page, 'store' | 'viewer'>} page */
export function groundPanel({ store, viewer }) {
  const choice = /** @type {HTMLSelectElement} */ (byId('ground'));
  const colour = /** @type {HTMLInputElement} */ (byId('ground-colour'));
  const file = /** @type {HTMLInputElement} */ (byId('ground-file'));
  choice.addEventListener('change', () => {
    const name = /** @type {GroundName} */ (choice.value);
    if (name === 'picture') file.click();
    // Without a picture it stays as it was.
    if (name === 'picture' && !store.state.ground.picture) choice.value = store.state.ground.name;
    else store.set({ ground: { ...store.state.ground, name } });
  });
  colour.addEventListener('input', () => store.set({ ground: { ...store.state.ground, colour: colour.value } }));
  file.addEventListener('change', async () => {
    const [picked] = file.files ?? [];
    file.value = '';
    if (!picked) return;
    try {
      const picture = await createImageBitmap(picked);
      store.set({ ground: { ...store.state.ground, name: 'picture', picture } });
    } catch {
      store.set(errorPatch(new PageError('unreadable-image', picked.name)));
    }
  });
  store.watch(['view', 'ground'], ({ view, ground }) => {
    byId('ground-row').hidden = view !== 'cutout';
    byId('screen').dataset.ground = ground.name;
    choice.value = ground.name;
    colour.hidden = ground.name !== 'colour';
    viewer.redraw();
  });
}

/**
 * Draws the frame's objects that are kept on their ground.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../layers/layer.js').View} view
 * @param {import('../../model/store.js').Ground} ground
 */
export function drawKept(ctx, { image, mask }, ground) {
  const edged = mask();
  if (!image || !edged) return;
  fromCorner(ctx, () => drawCutout(ctx, image, edged, { background: groundOf(ground) }));
}
