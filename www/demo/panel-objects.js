/** The list of clusters: colour, share of all points, show or hide, and show alone. @module */

import { byId, h, icon } from './dom.js';
import { clusterColor, clusterName, clusterShape } from './palette.js';
import { percent } from './words.js';

/**
 * @param {import('./points.js').Points | null} points
 * @param {import('./selection.js').Selection} selection
 */
export function fillObjects(points, selection) {
  const count = points?.result.clusters.count ?? 0;
  selection.reset(count);
  const rows = Array.from({ length: count }, (_, k) => objectRow(k, points?.share(k) ?? 0, selection));
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
 * @param {number} cluster
 * @param {number} share
 * @param {import('./selection.js').Selection} selection
 */
function objectRow(cluster, share, selection) {
  const name = clusterName(cluster);
  const swatch = h('span', { class: `swatch swatch-${clusterShape(cluster)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', clusterColor(cluster));
  const bar = h('span', { class: 'share-bar', 'aria-hidden': 'true' });
  bar.style.setProperty('--mark', clusterColor(cluster));
  bar.style.setProperty('--share', String(share));
  const alone = h(
    'button',
    { type: 'button', class: 'object-main', title: `Show ${name} alone`, click: () => selection.isolate(cluster) },
    swatch,
    h('span', { class: 'object-name' }, name),
    h('span', { class: 'object-share' }, percent(share)),
    bar,
  );
  const eye = h(
    'button',
    { type: 'button', class: 'icon-button eye', click: () => selection.toggle(cluster) },
    icon('icon-eye'),
    icon('icon-eye-off'),
  );
  const element = h('li', { class: 'object', 'data-cluster': cluster }, alone, eye);
  const update = () => {
    const shown = selection.has(cluster);
    element.classList.toggle('is-hidden', !shown);
    alone.setAttribute('aria-pressed', String(selection.isAlone(cluster)));
    eye.setAttribute('aria-label', `${shown ? 'Hide' : 'Show'} ${name}`);
    eye.title = shown ? 'Hide' : 'Show';
  };
  return { element, update };
}
