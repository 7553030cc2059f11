// How the result is looked at: over the original, beside it, behind a border that can be moved, or cut out on a
// ground.

import { byId } from '../dom.js';
import { drawCutout } from '../../model/library.js';
import { type GroundName, type View, groundOf } from '../../model/look.js';
import { type View as LayerView, fromCorner } from '../layers/layer.js';
import { type Ground, type Store, errorPatch } from '../../model/store.js';
import { PageError } from '../../model/words.js';
import type { Zoom } from '../../model/zoom.js';
import type { Page } from '../page.js';

const VIEWS: View[] = ['overlay', 'beside', 'slider', 'cutout'];

/** Narrower windows have no room for two wide pictures side by side: one lies above the other. */
const NARROW = matchMedia('(max-width: 599px)');

export function comparePanel({ keys, viewer }: Pick<Page, 'keys' | 'viewer'>) {
  keys.on('v', () => viewer.compare.next());
}

export class Compare {
  box = byId('screen');
  canvas = byId<HTMLCanvasElement>('original');
  split = byId<HTMLInputElement>('split');
  radios: HTMLInputElement[] = [...byId('views').querySelectorAll('input')];

  constructor(readonly store: Store) {
    for (const radio of this.radios) radio.addEventListener('change', () => store.set({ view: radio.value as View }));
    this.split.addEventListener('input', () => store.set({ split: Number(this.split.value) }));
    NARROW.addEventListener('change', () => this.showShape());
    store.watch(['view'], ({ view }) => this.showView(view));
    store.watch(['view', 'picture'], () => this.showShape());
    store.watch(['split'], ({ split }) => this.showSplit(split));
  }

  showView(view: View) {
    this.box.dataset.view = view;
    this.split.hidden = view !== 'slider';
    for (const radio of this.radios) radio.checked = radio.value === view;
  }

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

  showSplit(percent: number) {
    this.split.value = String(percent);
    this.box.style.setProperty('--split', String(percent / 100));
    this.split.setAttribute('aria-valuetext', `Original up to ${percent} %`);
  }

  /**
   * Draws the frame as it came.
   * @param like the canvas of the result, whose size it takes
   */
  draw(image: CanvasImageSource | null, like: HTMLCanvasElement, { by, x, y }: Zoom) {
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
    if (image) ctx.drawImage(image, -x * by * width, -y * by * height, by * width, by * height);
  }
}

export function groundPanel({ store, viewer }: Pick<Page, 'store' | 'viewer'>) {
  const choice = byId<HTMLSelectElement>('ground');
  const colour = byId<HTMLInputElement>('ground-colour');
  const file = byId<HTMLInputElement>('ground-file');
  choice.addEventListener('change', () => {
    const name = choice.value as GroundName;
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

/** Draws the frame's objects that are kept on their ground. */
export function drawKept(ctx: CanvasRenderingContext2D, { image, mask }: LayerView, ground: Ground) {
  const edged = mask();
  if (!image || !edged) return;
  fromCorner(ctx, () => drawCutout(ctx, image, edged, { background: groundOf(ground) }));
}
