// The bar that joins objects. The user selects them, or accepts a proposal of similar ones. Loaded with the
// corrections.

import { byId, h } from '../dom.js';
import { JoinProposals } from '../../model/join-proposals.js';
import { objectColor, objectName, objectShape } from '../../model/palette.js';
import { formatPlural } from '../../model/messages.js';
import { type Correction, boundingBox, drawBox } from './correction.js';
import type { Page } from '../page.js';

export class JoinBar {
  store: Page['store'];
  viewer: Page['viewer'];
  proposals: JoinProposals;
  lastJoin: { analysis: unknown; count: number } | null = null;
  isHovered = false;

  constructor(
    { store, viewer }: Pick<Page, 'store' | 'viewer'>,
    readonly correction: Correction,
  ) {
    this.store = store;
    this.viewer = viewer;
    byId('join-apply').addEventListener('click', () => this.join());
    byId('join-dismiss').addEventListener('click', () => this.dismiss());
    byId('join-undo').addEventListener('click', () => correction.undo());
    for (const name of ['pointerenter', 'focusin', 'pointerleave', 'focusout'])
      byId('join').addEventListener(name, () => this.setHovered(/enter|in$/.test(name)));
    viewer.painters.push((ctx, view) => {
      for (const object of this.marked) drawBox(ctx, view, boundingBox(view, object));
    });
    this.proposals = new JoinProposals(store, () => this.show());
    store.watch(['analysis', 'phase', 'selected'], () => this.show());
  }

  /** The objects that would be joined. */
  get candidates(): number[] {
    const { selected } = this.store.state;
    return selected.size > 0 ? [...selected] : (this.proposals.current ?? []);
  }

  /** The objects marked in the picture. */
  get marked(): number[] {
    return this.store.state.selected.size > 0 || this.isHovered ? this.candidates : [];
  }

  show() {
    const { selected, analysis, phase } = this.store.state;
    const { candidates, lastJoin } = this;
    const isDone = lastJoin?.analysis === analysis && selected.size === 0;
    const shows = phase === 'done' && (isDone || candidates.length > 0);
    byId('join').hidden = !shows;
    for (const row of document.querySelectorAll('.object')) {
      const object = Number((row as HTMLElement).dataset.object);
      row.classList.toggle('is-candidate', shows && !isDone && candidates.includes(object));
    }
    this.viewer.redraw();
    if (!shows) return;
    byId('join-message').replaceChildren(...(isDone ? [] : candidates.map(createSwatch)), this.message(isDone));
    const button = byId<HTMLButtonElement>('join-apply');
    button.hidden = byId('join-dismiss').hidden = isDone;
    button.disabled = candidates.length < 2;
    byId('join-dismiss').textContent = selected.size > 0 ? 'Clear selection' : 'Dismiss';
    byId('join-undo').hidden = !isDone;
  }

  message(isDone: boolean) {
    const { selected } = this.store.state;
    if (isDone) return `${formatPlural(this.lastJoin?.count ?? 0, 'object')} joined.`;
    if (selected.size === 0) return `${this.candidates.length} pieces look like one.`;
    return selected.size > 1 ? `${formatPlural(selected.size, 'object')} selected` : 'Select one more object to join.';
  }

  async join() {
    const [into, ...objects] = this.candidates;
    if (objects.length === 0) return;
    const hadFocus = byId('join').contains(document.activeElement);
    const { analysis } = this.store.state;
    await this.correction.join(into, objects);
    if (this.store.state.analysis === analysis) return;
    this.lastJoin = { analysis: this.store.state.analysis, count: objects.length + 1 };
    this.show();
    // The focused button is hidden now.
    if (hadFocus) byId('join-undo').focus();
  }

  dismiss() {
    const { selected } = this.store.state;
    if (selected.size === 0) this.proposals.dismiss();
    this.store.set({ selected: new Set() });
    this.show();
    if (byId('join').hidden) document.querySelector<HTMLElement>('.object-main')?.focus();
  }

  /** @param isHovered true if the pointer or the focus is on the bar */
  setHovered(isHovered: boolean) {
    this.isHovered = isHovered;
    this.viewer.redraw();
  }
}

function createSwatch(object: number) {
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  return h('span', { title: objectName(object) }, swatch, h('span', { class: 'visually-hidden' }, objectName(object)));
}
