// View modes: overlay, side by side, slider, and cut-out on a backdrop.

import { byId } from '../dom.js';
import { drawCutout } from '../../model/library.js';
import { type BackdropName, type View, toCutoutBackdrop } from '../../model/view-settings.js';
import { type View as LayerView, fromCorner } from '../layers.js';
import { type Backdrop, type Store, errorPatch } from '../../model/store.js';
import { PageError } from '../../model/messages.js';
import type { Zoom } from '../../model/zoom.js';
import type { Page } from '../page.js';

const VIEWS: View[] = ['overlay', 'beside', 'slider', 'cutout'];

/** Windows too narrow for two wide pictures side by side, which are stacked then. */
const NARROW = matchMedia('(max-width: 599px)');

export function comparePanel({ keys, viewer }: Pick<Page, 'keys' | 'viewer'>) {
  keys.on('v', () => viewer.compare.showNextView());
}

export class Compare {
  box = byId('screen');
  canvas = byId<HTMLCanvasElement>('original');
  split = byId<HTMLInputElement>('split');
  radios: HTMLInputElement[] = [...byId('views').querySelectorAll('input')];

  constructor(readonly store: Store) {
    for (const radio of this.radios) radio.addEventListener('change', () => store.set({ view: radio.value as View }));
    this.split.addEventListener('input', () => store.set({ dividerPercent: Number(this.split.value) }));
    NARROW.addEventListener('change', () => this.showShape());
    store.watch(['view'], ({ view }) => this.showView(view));
    store.watch(['view', 'picture'], () => this.showShape());
    store.watch(['dividerPercent'], ({ dividerPercent }) => this.showSplit(dividerPercent));
  }

  showView(view: View) {
    this.box.dataset.view = view;
    this.split.hidden = view !== 'slider';
    for (const radio of this.radios) radio.checked = radio.value === view;
  }

  showNextView() {
    const { view } = this.store.state;
    this.store.set({ view: VIEWS[(VIEWS.indexOf(view) + 1) % VIEWS.length] });
  }

  /** Sets the aspect ratio of one picture or of two. */
  showShape() {
    const { view, picture } = this.store.state;
    const stacks = NARROW.matches && picture.width > picture.height;
    const aspectFactor = view === 'beside' ? (stacks ? 0.5 : 2) : 1;
    this.box.toggleAttribute('data-stacks', stacks);
    this.box.parentElement?.style.setProperty('--aspect', String((picture.width / picture.height) * aspectFactor));
  }

  showSplit(percent: number) {
    this.split.value = String(percent);
    this.box.style.setProperty('--split', String(percent / 100));
    this.split.setAttribute('aria-valuetext', `Original up to ${percent}%`);
  }

  /**
   * Draws the original frame.
   * @param like the canvas of the result, which gives the size
   */
  draw(image: CanvasImageSource | null, like: HTMLCanvasElement, { scale, x, y }: Zoom) {
    if (!['beside', 'slider'].includes(this.store.state.view)) return;
    const { canvas, box } = this;
    if (canvas.width !== like.width || canvas.height !== like.height)
      Object.assign(canvas, { width: like.width, height: like.height });
    for (const side of ['width', 'height'] as const) {
      canvas.style[side] = like.style[side];
      box.style.setProperty(`--${side}`, like.style[side]);
    }
    const ctx = canvas.getContext('2d')!;
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    ctx.imageSmoothingQuality = 'high';
    const { width, height } = canvas;
    if (image) ctx.drawImage(image, -x * scale * width, -y * scale * height, scale * width, scale * height);
  }
}

export function backdropPanel({ store, viewer }: Pick<Page, 'store' | 'viewer'>) {
  const choice = byId<HTMLSelectElement>('backdrop');
  const colour = byId<HTMLInputElement>('backdrop-colour');
  const file = byId<HTMLInputElement>('backdrop-file');
  choice.addEventListener('change', () => {
    const name = choice.value as BackdropName;
    if (name === 'picture') file.click();
    // Keeps the backdrop until a picture is picked.
    if (name === 'picture' && !store.state.backdrop.picture) choice.value = store.state.backdrop.name;
    else store.set({ backdrop: { ...store.state.backdrop, name } });
  });
  colour.addEventListener('input', () => store.set({ backdrop: { ...store.state.backdrop, colour: colour.value } }));
  file.addEventListener('change', async () => {
    const [picked] = file.files ?? [];
    file.value = '';
    if (!picked) return;
    try {
      const picture = await createImageBitmap(picked);
      store.set({ backdrop: { ...store.state.backdrop, name: 'picture', picture } });
    } catch {
      store.set(errorPatch(new PageError('unreadable-image', picked.name)));
    }
  });
  store.watch(['view', 'backdrop'], ({ view, backdrop }) => {
    byId('backdrop-row').hidden = view !== 'cutout';
    byId('screen').dataset.backdrop = backdrop.name;
    choice.value = backdrop.name;
    colour.hidden = backdrop.name !== 'colour';
    viewer.redraw();
  });
}

/** Draws the shown objects on the backdrop. */
export function drawCutoutView(ctx: CanvasRenderingContext2D, { image, mask }: LayerView, backdrop: Backdrop) {
  const edged = mask();
  if (!image || !edged) return;
  fromCorner(ctx, () => drawCutout(ctx, image, edged, { background: toCutoutBackdrop(backdrop) }));
}
