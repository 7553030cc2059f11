/** The list of layers: a switch, a key and, for layers that are on, the legend and their settings. @module */

import { byId, h } from '../dom.js';
import { missingOf } from '../layers/layers.js';
import { kindOf } from '../source.js';

/** @typedef {import('../layers/layer.js').Layer} Layer */

/** Where the layers are that everybody wants; the others show how it works. @type {Record<string, string>} */
const PLACES = { masks: 'layer-list', image: 'layer-list-last' };

/** @param {Pick<import('../page.js').Page, 'store' | 'layers' | 'viewer' | 'keys'>} page */
export function layersPanel({ store, layers, viewer, keys }) {
  const rows = layers.map((layer) => layerRow(layer, () => viewer.redraw()));
  for (const { layer, element } of rows) byId(PLACES[layer.id] ?? 'layer-list-how').append(element);
  // Layers that share a key are never there at the same time.
  const rowOf = (/** @type {string} */ key) =>
    rows.find(({ layer }) => layer.key === key && isFor(layer, kindOf(store.state.source)));
  for (const key of new Set(layers.map((layer) => layer.key)))
    keys.on(
      key,
      () => rowOf(key)?.box.click(),
      () => rowOf(key) !== undefined,
    );
  // Of a still image these are the result.
  store.watch(['source'], ({ source }) => {
    if (kindOf(source) === 'still') /** @type {HTMLDetailsElement} */ (byId('layers-all')).open = true;
  });
  store.watch(['source', 'picture', 'found'], ({ source }) => {
    for (const row of rows) row.update(viewer.view, kindOf(source));
  });
}

/**
 * @param {Layer} layer
 * @param {'clip' | 'still'} kind
 */
function isFor(layer, kind) {
  return (layer.only ?? kind) === kind;
}

/**
 * @param {Layer} layer
 * @param {() => void} onChange
 */
function layerRow(layer, onChange) {
  const shortcut = layer.key.toUpperCase();
  const box = h('input', {
    type: 'checkbox',
    role: 'switch',
    class: 'switch',
    'data-layer': layer.id,
    'aria-keyshortcuts': shortcut,
  });
  box.checked = layer.on;
  const legend = h('div', { class: 'legend' });
  const missing = h('p', { class: 'about layer-missing', id: `missing-${layer.id}`, hidden: true });
  const details = h(
    'div',
    { class: 'layer-details' },
    h('p', { class: 'about' }, layer.about),
    legend,
    ...Object.entries(layer.settings).map(([name, setting]) => controlOf(setting)(layer.id, name, setting, onChange)),
  );
  let reason = '';
  const refresh = () => {
    const nodes = layer.on ? layer.legend() : [];
    legend.replaceChildren(...nodes);
    legend.hidden = nodes.length === 0;
    details.hidden = !layer.on || reason !== '';
  };
  layer.changed = refresh;
  box.addEventListener('change', () => {
    layer.on = box.checked;
    refresh();
    onChange();
  });
  refresh();
  const key = h('kbd', { title: 'Key', 'aria-hidden': 'true' }, shortcut);
  const label = h('label', { class: 'layer-name' }, box, h('span', {}, layer.name), key);
  const element = h('li', { class: 'layer' }, label, missing, details);
  /**
   * @param {import('../layers/layer.js').View} view
   * @param {'clip' | 'still'} kind
   */
  const update = (view, kind) => {
    element.hidden = !isFor(layer, kind);
    reason = missingOf(layer, view);
    box.disabled = reason !== '';
    if (reason) box.setAttribute('aria-describedby', missing.id);
    else box.removeAttribute('aria-describedby');
    missing.textContent = reason;
    missing.hidden = reason === '';
    refresh();
  };
  return { layer, box, element, update };
}

/** @param {import('../layers/layer.js').Setting} setting */
function controlOf(setting) {
  if (setting.choices) return selectBox;
  return setting.toggle ? miniSwitch : slider;
}

/**
 * @param {string} layerId
 * @param {string} name
 * @param {import('../layers/layer.js').Setting} setting
 * @param {() => void} onChange
 * @returns {HTMLElement}
 */
function slider(layerId, name, setting, onChange) {
  const { min, max, step } = setting;
  const input = h('input', {
    type: 'range',
    min,
    max,
    step,
    value: setting.value,
    'data-setting': `${layerId}.${name}`,
  });
  // The slider itself tells its value to screen readers.
  const output = h('span', { class: 'value', 'aria-hidden': 'true' });
  const show = () => {
    output.textContent = setting.text(setting.value);
    input.setAttribute('aria-valuetext', setting.text(setting.value));
    input.style.setProperty('--share', String((setting.value - min) / (max - min)));
  };
  input.addEventListener('input', () => {
    setting.value = Number(input.value);
    show();
    onChange();
  });
  show();
  return h('label', { class: 'slider' }, h('span', {}, setting.name), input, output);
}

/**
 * @param {string} layerId
 * @param {string} name
 * @param {import('../layers/layer.js').Setting} setting
 * @param {() => void} onChange
 * @returns {HTMLElement}
 */
function miniSwitch(layerId, name, setting, onChange) {
  const box = h('input', { type: 'checkbox', role: 'switch', class: 'switch', 'data-setting': `${layerId}.${name}` });
  box.checked = setting.value > 0;
  box.addEventListener('change', () => {
    setting.value = box.checked ? 1 : 0;
    onChange();
  });
  return h('label', { class: 'toggle' }, h('span', {}, setting.name), box);
}

/**
 * @param {string} layerId
 * @param {string} name
 * @param {import('../layers/layer.js').Setting} setting
 * @param {() => void} onChange
 * @returns {HTMLElement}
 */
function selectBox(layerId, name, setting, onChange) {
  const options = (setting.choices ?? []).map((text, value) =>
    h('option', { value, selected: value === setting.value }, text),
  );
  const select = h('select', { 'data-setting': `${layerId}.${name}` }, ...options);
  select.addEventListener('change', () => {
    setting.value = Number(select.value);
    onChange();
  });
  return h('label', { class: 'field' }, setting.name, select);
}
