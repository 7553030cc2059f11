// Joining: objects that are one thing become one, in one step. The user chooses them; those that look like one are
// proposed. Fetched with what corrects.

import { byId, h } from '../dom.js';
import { alikeObjects } from '../../model/alike.js';
import { objectColor, objectName, objectShape } from '../../model/palette.js';
import { plural } from '../../model/words.js';
import { type Correction, boxOf, drawFrame } from './correction.js';
import type { Page } from '../page.js';

/** A result that stays for so long is looked at, in milliseconds. */
const WAIT_MS = 200;

export class JoinBar {
  store: Page['store'];
  viewer: Page['viewer'];
  /** Groups that look like one thing. */
  alike: number[][] = [];
  /** Groups that the user does not want. */
  refused = new Set<string>();
  /** What was joined last, and the result of it. */
  joined: { found: unknown; count: number } | null = null;
  pointed = false;
  timer = 0;

  constructor(
    { store, viewer }: Pick<Page, 'store' | 'viewer'>,
    readonly correction: Correction,
  ) {
    this.store = store;
    this.viewer = viewer;
    byId('join-do').addEventListener('click', () => this.join());
    byId('join-no').addEventListener('click', () => this.refuse());
    byId('join-undo').addEventListener('click', () => correction.undo());
    for (const name of ['pointerenter', 'focusin', 'pointerleave', 'focusout'])
      byId('join').addEventListener(name, () => this.point(/enter|in$/.test(name)));
    viewer.painters.push((ctx, view) => {
      for (const object of this.marked) drawFrame(ctx, view, boxOf(view, object));
    });
    store.watch(['visit'], () => this.refused.clear());
    store.watch(['found', 'phase'], () => this.look());
    store.watch(['found', 'phase', 'chosen'], () => this.show());
  }

  /** Returns the objects that would be joined. */
  get meant(): number[] {
    const { chosen } = this.store.state;
    return chosen.size > 0 ? [...chosen] : (this.proposal ?? []);
  }

  /** Returns the objects that are marked in the picture. */
  get marked(): number[] {
    return this.store.state.chosen.size > 0 || this.pointed ? this.meant : [];
  }

  get proposal() {
    return this.alike.find((group) => !this.refused.has(String(group)));
  }

  /** Looks which objects are alike, when there is time. */
  look() {
    this.alike = [];
    clearTimeout(this.timer);
    const { found, phase } = this.store.state;
    const points = found?.points;
    if (phase !== 'done' || !points || !this.correction.corrector) return;
    this.timer = window.setTimeout(() => {
      const { width, height, numFrames, trajectories } = points.result;
      const labels = (t: number) => points.mask(t)!;
      this.alike = alikeObjects({ width, height, numFrames, trajectories, labels, scene: points.scene });
      this.show();
    }, WAIT_MS);
  }

  show() {
    const { chosen, found, phase } = this.store.state;
    const { meant, joined } = this;
    const isDone = joined?.found === found && chosen.size === 0;
    const shows = phase === 'done' && (isDone || meant.length > 0);
    byId('join').hidden = !shows;
    for (const row of document.querySelectorAll('.object')) {
      const object = Number((row as HTMLElement).dataset.object);
      row.classList.toggle('is-meant', shows && !isDone && meant.includes(object));
    }
    this.viewer.redraw();
    if (!shows) return;
    byId('join-words').replaceChildren(...(isDone ? [] : meant.map(swatchOf)), this.words(isDone));
    const button = byId<HTMLButtonElement>('join-do');
    button.hidden = byId('join-no').hidden = isDone;
    button.disabled = meant.length < 2;
    byId('join-no').textContent = chosen.size > 0 ? 'Choose none' : 'Dismiss';
    byId('join-undo').hidden = !isDone;
  }

  words(isDone: boolean) {
    const { chosen } = this.store.state;
    if (isDone) return `${plural(this.joined?.count ?? 0, 'object')} joined.`;
    if (chosen.size === 0) return `These ${this.meant.length} look like one: join?`;
    return chosen.size > 1 ? `${plural(chosen.size, 'object')} chosen` : 'Choose another one too.';
  }

  async join() {
    const [into, ...others] = this.meant;
    if (others.length === 0) return;
    const held = byId('join').contains(document.activeElement);
    const { found } = this.store.state;
    await this.correction.apply((corrector) => corrector.join(into, others));
    if (this.store.state.found === found) return;
    this.joined = { found: this.store.state.found, count: others.length + 1 };
    this.show();
    // The button that had it is gone.
    if (held) byId('join-undo').focus();
  }

  refuse() {
    const { chosen } = this.store.state;
    if (chosen.size === 0) this.refused.add(String(this.proposal));
    this.store.set({ chosen: new Set() });
    this.show();
    if (byId('join').hidden) document.querySelector<HTMLElement>('.object-main')?.focus();
  }

  /** @param pointed whether the pointer or the focus is here */
  point(pointed: boolean) {
    this.pointed = pointed;
    this.viewer.redraw();
  }
}

function swatchOf(object: number) {
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  return h('span', { title: objectName(object) }, swatch, h('span', { class: 'visually-hidden' }, objectName(object)));
}
