// The list of objects: colour, size, when and where they are there; which are kept, on screen and in what is saved.

import { byId, choosesMore, h } from '../dom.js';
import { moveOf, nameAndColour, placeName } from '../../model/describe.js';
import { objectColor, objectName, objectShape } from '../../model/palette.js';
import { type Selection, listed } from '../../model/selection.js';
import { percent } from '../../model/words.js';
import { Lanes } from './lanes.js';
import type { Facts } from '../../model/presence.js';
import type { Page } from '../page.js';

export function objectsPanel({ store, selection, viewer }: Pick<Page, 'store' | 'selection' | 'viewer'>) {
  let rows: ReturnType<typeof objectRow>[] = [];
  const list = byId('object-list');
  const lanes = new Lanes(store, list);
  store.watch(['found', 'film'], ({ found }) => {
    lanes.strips = [];
    rows = listed(found?.facts ?? []).map((one) => objectRow(one, selection, lanes));
    list.replaceChildren(...rows.map((row) => row.element));
    lanes.draw();
  });
  store.watch(['found', 'film', 'hidden', 'chosen'], ({ hidden }) => {
    rows.forEach((row) => row.update());
    byId('show-all').hidden = hidden.size === 0;
  });
  byId('show-all').addEventListener('click', () => selection.reset());
  viewer.onPick(({ object }, more) => {
    if (store.state.correcting) return;
    if (more) return selection.choose(object);
    if (object > 0) selection.isolate(object);
    // The background brings all back.
    else if (object === 0) selection.reset();
  });
}

function objectRow(facts: Facts, selection: Selection, lanes: Lanes) {
  const { object, share } = facts;
  const name = objectName(object);
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  const chosen = h('span', { class: 'visually-hidden' });
  const choose = (event: MouseEvent | KeyboardEvent) => {
    event.preventDefault();
    selection.choose(object);
  };
  const alone = h(
    'button',
    {
      ...{ type: 'button', class: 'object-main', title: `Show ${name} alone` },
      click: (event: MouseEvent) => (choosesMore(event) ? choose(event) : selection.isolate(object)),
      // Not every browser says of the click by a key that shift is held.
      keydown: (event: KeyboardEvent) => event.key === 'Enter' && event.shiftKey && choose(event),
    },
    swatch,
    h(
      'span',
      { class: 'object-name' },
      name,
      h('span', { class: 'visually-hidden' }, `, ${nameAndColour(object)}`),
      chosen,
    ),
    h('span', { class: 'object-share' }, percent(share)),
    h('span', { class: 'object-facts' }, factsOf(facts)),
  );
  const element = h('li', { class: 'object', 'data-object': object }, alone);
  const keep = object > 0 ? keepOf(object, selection) : null;
  if (keep) element.append(keep.element);
  if (object > 0 && facts.first >= 0) element.append(lanes.add(facts));
  const update = () => {
    const shown = selection.has(object);
    element.classList.toggle('is-hidden', !shown);
    alone.setAttribute('aria-pressed', String(selection.isAlone(object)));
    chosen.textContent = selection.isChosen(object) ? ', chosen' : '';
    keep?.update(shown);
  };
  return { element, update };
}

function keepOf(object: number, selection: Selection) {
  const box = h('input', {
    type: 'checkbox',
    'aria-label': `Keep ${objectName(object)}`,
    change: () => selection.toggle(object),
  });
  const element = h('label', { class: 'keep', title: 'Keep it on screen, and in what is saved' }, box, 'Keep');
  const update = (shown: boolean) => (box.checked = shown);
  return { element, update };
}

/** Returns `top, moves left`. */
function factsOf(facts: Facts): string {
  if (facts.first < 0) return 'not seen';
  return facts.object > 0 ? `${placeName(facts.from)}, ${moveOf(facts)}` : '';
}
