// The list of objects: colour, size, time and position, and whether they are kept.

import { byId, isMultiSelect, h } from '../dom.js';
import { describeMotion, describePosition } from '../../model/describe.js';
import { colourName, objectColor, objectName, objectShape } from '../../model/palette.js';
import { type Selection, listObjects } from '../../model/selection.js';
import { formatPercent } from '../../model/messages.js';
import { Lanes } from './lanes.js';
import type { ObjectFacts } from '../../model/presence.js';
import type { Page } from '../page.js';

export function objectsPanel({ store, selection, viewer }: Pick<Page, 'store' | 'selection' | 'viewer'>) {
  let rows: ReturnType<typeof createRow>[] = [];
  const list = byId('object-list');
  const lanes = new Lanes(store, list);
  store.watch(['analysis', 'timeline'], ({ analysis }) => {
    lanes.strips = [];
    rows = listObjects(analysis?.facts ?? []).map((objectFacts) => createRow(objectFacts, selection, lanes));
    list.replaceChildren(...rows.map((row) => row.element));
    lanes.draw();
  });
  store.watch(['analysis', 'timeline', 'hidden', 'selected'], ({ hidden }) => {
    rows.forEach((row) => row.update());
    byId('show-all').hidden = hidden.size === 0;
  });
  byId('show-all').addEventListener('click', () => selection.reset());
  viewer.onPick(({ object }, isMulti) => {
    if (store.state.isCorrecting) return;
    if (isMulti) return selection.toggleSelected(object);
    if (object > 0) selection.isolate(object);
    // A click on the background shows all.
    else if (object === 0) selection.reset();
  });
}

function createRow(facts: ObjectFacts, selection: Selection, lanes: Lanes) {
  const { object, share } = facts;
  const name = objectName(object);
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  const note = h('span', { class: 'visually-hidden' });
  const select = (event: MouseEvent | KeyboardEvent) => {
    event.preventDefault();
    selection.toggleSelected(object);
  };
  const button = h(
    'button',
    {
      ...{ type: 'button', class: 'object-main', title: `Show only ${name}` },
      click: (event: MouseEvent) => (isMultiSelect(event) ? select(event) : selection.isolate(object)),
      // Not every browser reports the shift key of a click by keyboard.
      keydown: (event: KeyboardEvent) => event.key === 'Enter' && event.shiftKey && select(event),
    },
    swatch,
    h('span', { class: 'object-name' }, name, note),
    h('span', { class: 'object-share' }, formatPercent(share)),
    h('span', { class: 'object-facts' }, describeFacts(facts)),
  );
  const element = h('li', { class: 'object', 'data-object': object }, button);
  const keep = object > 0 ? createKeepBox(object, selection) : null;
  if (keep) element.append(keep.element);
  if (object > 0 && facts.first >= 0) element.append(lanes.add(facts));
  const update = () => {
    const isKept = selection.has(object);
    element.classList.toggle('is-hidden', !isKept);
    button.setAttribute('aria-pressed', String(selection.isAlone(object)));
    note.textContent = ` (${colourName(object)})${selection.isSelected(object) ? ', selected' : ''}`;
    keep?.update(isKept);
  };
  return { element, update };
}

function createKeepBox(object: number, selection: Selection) {
  const box = h('input', {
    type: 'checkbox',
    'aria-label': `Keep ${objectName(object)}`,
    change: () => selection.toggle(object),
  });
  const element = h('label', { class: 'keep', title: 'Keep on screen and when saving' }, box);
  const update = (isKept: boolean) => (box.checked = isKept);
  return { element, update };
}

/** Returns `top, moves left`. */
function describeFacts(facts: ObjectFacts): string {
  if (facts.first < 0) return 'not seen';
  return facts.object > 0 ? `${describePosition(facts.from)}, ${describeMotion(facts)}` : '';
}
