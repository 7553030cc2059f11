/**
 * The list of objects: colour, size, when and where they are there; which are kept, on screen and in what is saved.
 * @module
 */

import { byId, h, icon } from '../dom.js';
import { moveOf, nameAndColour, placeName, spanOf } from '../result/describe.js';
import { objectColor, objectName, objectShape } from '../result/palette.js';
import { listed } from '../result/selection.js';
import { percent, plural } from '../words.js';
import { say } from '../language.js';

/** @typedef {import('../result/presence.js').Facts} Facts */
/** @typedef {import('../result/selection.js').Selection} Selection */
/** @typedef {import('../result/presence.js').Times} Times */

/** @param {Pick<import('../page.js').Page, 'store' | 'selection' | 'viewer'>} page */
export function objectsPanel({ store, selection, viewer }) {
  /** @type {ReturnType<typeof objectRow>[]} */
  let rows = [];
  store.watch(['found'], ({ found, film }) => {
    const motionsOf = (/** @type {number} */ object) => found?.points?.clustersOf(object) ?? 1;
    rows = listed(found?.facts ?? []).map((one) => objectRow(one, motionsOf(one.object), film.times, selection));
    byId('object-list').replaceChildren(...rows.map((row) => row.element));
  });
  store.watch(['found', 'hidden'], ({ hidden }) => {
    rows.forEach((row) => row.update());
    byId('show-all').hidden = hidden.size === 0;
  });
  byId('show-all').addEventListener('click', () => selection.reset());
  viewer.onPick(({ object }) => {
    if (store.state.correcting || store.state.asking) return;
    if (object > 0) selection.isolate(object);
    // The background brings all back.
    else if (object === 0) selection.reset();
  });
}

/**
 * @param {Facts} facts
 * @param {number} motions
 * @param {Times} times
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
    { type: 'button', class: 'object-main', title: say`Show ${name} alone`, click: () => selection.isolate(object) },
    swatch,
    h('span', { class: 'object-name' }, name, h('span', { class: 'visually-hidden' }, `, ${nameAndColour(object)}`)),
    h('span', { class: 'object-share' }, percent(share)),
    bar,
    h('span', { class: 'object-facts' }, factsOf(facts, motions, times)),
  );
  const shows = object === 0 ? eyeOf(selection) : keepOf(object, selection);
  const element = h('li', { class: 'object', 'data-object': object }, alone, shows.element);
  const update = () => {
    const shown = selection.has(object);
    element.classList.toggle('is-hidden', !shown);
    alone.setAttribute('aria-pressed', String(selection.isAlone(object)));
    shows.update(shown);
  };
  return { element, update };
}

/**
 * The background is no object that is kept: it is shown or hidden.
 *
 * @param {Selection} selection
 */
function eyeOf(selection) {
  const element = h(
    'button',
    { type: 'button', class: 'icon-button eye', click: () => selection.toggle(0) },
    icon('icon-eye'),
    icon('icon-eye-off'),
  );
  const update = (/** @type {boolean} */ shown) => {
    element.setAttribute('aria-label', shown ? say`Hide ${objectName(0)}` : say`Show ${objectName(0)}`);
    element.title = shown ? say('Hide') : say('Show');
  };
  return { element, update };
}

/**
 * @param {number} object
 * @param {Selection} selection
 */
function keepOf(object, selection) {
  const box = h('input', {
    type: 'checkbox',
    'aria-label': say`Keep ${objectName(object)}`,
    change: () => selection.toggle(object),
  });
  const element = h('label', { class: 'keep', title: 'Keep it on screen, and in what is saved' }, box, 'Keep');
  const update = (/** @type {boolean} */ shown) => (box.checked = shown);
  return { element, update };
}

/**
 * @param {Facts} facts
 * @param {number} motions
 * @param {Times} times
 * @returns {string} `top, moves left · 0.0–1.6 s`
 */
function factsOf(facts, motions, times) {
  const parts =
    facts.object > 0 && facts.first >= 0 ? [`${placeName(facts.from)}, ${moveOf(facts)}`, spanOf(facts, times)] : [];
  if (facts.first < 0) parts.push(say('not seen'));
  if (motions > 1) parts.push(plural(motions, 'motion'));
  return parts.join(' · ');
}
