/** The list of objects: colour, size, when and where they are there; show or hide, and show alone. @module */

import { moveOf, nameAndColour, placeName, spanOf } from './describe.js';
import { byId, h, icon } from './dom.js';
import { objectColor, objectName, objectShape } from './palette.js';
import { percent, plural } from './words.js';

/** @typedef {import('./presence.js').Facts} Facts */
/** @typedef {import('./selection.js').Selection} Selection */

/** The last list's listener would keep its rows alive. */
let stopRows = () => {};

/**
 * @param {Facts[]} facts of all objects in the order of their numbers
 * @param {Selection} selection
 * @param {{times: import('./times.js').Times, motionsOf: (object: number) => number}} clip how many motions make up an object
 */
export function fillObjects(facts, selection, { times, motionsOf }) {
  stopRows();
  selection.resize(facts.reduce((most, { object }) => Math.max(most, object + 1), 0));
  const rows = facts.map((one) => objectRow(one, motionsOf(one.object), times, selection));
  byId('object-list').replaceChildren(...rows.map((row) => row.element));
  const update = () => {
    rows.forEach((row) => row.update());
    byId('show-all').hidden = selection.hidden.size === 0;
  };
  selection.addEventListener('change', update);
  stopRows = () => selection.removeEventListener('change', update);
  update();
}

/** @param {Selection} selection */
export function clearObjects(selection) {
  fillObjects([], selection, { times: /** @type {any} */ (null), motionsOf: () => 1 });
}

/**
 * @param {Facts} facts
 * @param {number} motions
 * @param {import('./times.js').Times} times
 * @param {Selection} selection
 */
function objectRow(facts, motions, times, selection) {
  const { object, share } = facts;
  const name = objectName(object);
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  const bar = h('span', { class: 'share-bar', 'aria-hidden': 'true' });
  bar.style.setProperty('--mark', objectColor(object));
  bar.style.setProperty('--share', String(share));
  const alone = h(
    'button',
    { type: 'button', class: 'object-main', title: `Show ${name} alone`, click: () => selection.isolate(object) },
    swatch,
    h('span', { class: 'object-name' }, name, h('span', { class: 'visually-hidden' }, `, ${nameAndColour(object)}`)),
    h('span', { class: 'object-share' }, percent(share)),
    bar,
    h('span', { class: 'object-facts' }, factsOf(facts, motions, times)),
  );
  const eye = h(
    'button',
    { type: 'button', class: 'icon-button eye', click: () => selection.toggle(object) },
    icon('icon-eye'),
    icon('icon-eye-off'),
  );
  const element = h('li', { class: 'object', 'data-object': object }, alone, eye);
  const update = () => {
    const shown = selection.has(object);
    element.classList.toggle('is-hidden', !shown);
    alone.setAttribute('aria-pressed', String(selection.isAlone(object)));
    eye.setAttribute('aria-label', `${shown ? 'Hide' : 'Show'} ${name}`);
    eye.title = shown ? 'Hide' : 'Show';
  };
  return { element, update };
}

/**
 * @param {Facts} facts
 * @param {number} motions
 * @param {import('./times.js').Times} times
 * @returns {string} `top, moves left · 0.0–1.6 s`
 */
function factsOf(facts, motions, times) {
  const parts = facts.object > 0 && facts.first >= 0 ? [`${placeName(facts.from)}, ${moveOf(facts)}`, spanOf(facts, times)] : [];
  if (facts.first < 0) parts.push('not seen');
  if (motions > 1) parts.push(plural(motions, 'motion'));
  return parts.join(' · ');
}
