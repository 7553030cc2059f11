/** The list of objects: colour, share of all pixels, show or hide, and show alone. @module */

import { byId, h, icon } from './dom.js';
import { objectColor, objectName, objectShape } from './palette.js';
import { percent, plural } from './words.js';

/**
 * @param {import('./points.js').Points | null} points
 * @param {import('./selection.js').Selection} selection
 */
export function fillObjects(points, selection) {
  const count = points?.count ?? 0;
  selection.reset(count);
  const rows = Array.from({ length: count }, (_, k) => objectRow(k, points?.share(k) ?? 0, points?.clustersOf(k) ?? 1, selection));
  byId('object-list').replaceChildren(...rows.map((row) => row.element));
  // The last result's listener would keep its rows alive.
  /** @type {any} */ (selection).stopRows?.();
  const update = () => {
    rows.forEach((row) => row.update());
    byId('show-all').hidden = selection.hidden.size === 0;
  };
  selection.addEventListener('change', update);
  /** @type {any} */ (selection).stopRows = () => selection.removeEventListener('change', update);
  update();
}

/**
 * @param {number} object
 * @param {number} share
 * @param {number} clusters how many make it up
 * @param {import('./selection.js').Selection} selection
 */
function objectRow(object, share, clusters, selection) {
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
    h('span', { class: 'object-name' }, clusters > 1 ? `${name} (${plural(clusters, 'motion')})` : name),
    h('span', { class: 'object-share' }, percent(share)),
    bar,
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
