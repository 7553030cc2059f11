/** The list of layers: a switch, a key and, for layers that are on, the legend and their settings. @module */

import { byId, h } from './dom.js';
import { missingOf } from './layers.js';

/** @typedef {import('./layer.js').Layer} Layer */

/**
 * @typedef {object} LayersPanel
 * @property {(key: string) => (() => void) | undefined} action what a key does, if anything
 * @property {(view: import('./layer.js').View, kind: string | undefined) => void} update shows the layers of this kind of source, and
 *   which of them have nothing to show
 */

/**
 * @param {Layer[]} layers
 * @param {() => void} onChange
 * @returns {LayersPanel}
 */
export function layersPanel(layers, onChange) {
  const rows = layers.map((layer) => layerRow(layer, onChange));
  byId('layer-list').replaceChildren(...rows.map((row) => row.element));
  return {
    action(key) {
      const row = rows.find(({ layer, element }) => layer.key === key.toLowerCase() && !element.hidden);
      return row && (() => row.box.click());
    },
    update(view, kind) {
      rows.forEach((row) => row.update(view, kind === 'still' ? 'still' : 'clip'));
    },
  };
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
  const refresh = () => {
    layer.on = box.checked;
    details.hidden = !layer.on || box.disabled;
    if (layer.on) legend.replaceChildren(...layer.legend());
    legend.hidden = legend.childElementCount === 0;
  };
  layer.changed = refresh;
  box.addEventListener('change', () => {
    refresh();
    onChange();
  });
  refresh();
  const key = h('kbd', { title: 'Key', 'aria-hidden': 'true' }, shortcut);
  const label = h('label', { class: 'layer-name' }, box, h('span', {}, layer.name), key);
  const element = h('li', { class: 'layer' }, label, missing, details);
  /**
   * @param {import('./layer.js').View} view
   * @param {'clip' | 'still'} kind
   */
  const update = (view, kind) => {
    element.hidden = (layer.only ?? kind) !== kind;
    const reason = missingOf(layer, view);
    box.disabled = reason !== '';
    if (reason) box.setAttribute('aria-describedby', missing.id);
    else box.removeAttribute('aria-describedby');
    missing.textContent = reason;
    missing.hidden = reason === '';
    refresh();
  };
  return { layer, box, element, update };
}

/** @param {import('./layer.js').Setting} setting */
function controlOf(setting) {
  if (setting.choices) return selectBox;
  return setting.toggle ? miniSwitch : slider;
}

/**
 * @param {string} layerId
 * @param {string} name
 * @param {import('./layer.js').Setting} setting
 * @param {() => void} onChange
 * @returns {HTMLElement}
 */
function slider(layerId, name, setting, onChange) {
  const { min, max, step } = setting;
  const input = h('input', { type: 'range', min, max, step, value: setting.value, 'data-setting': `${layerId}.${name}` });
  // The slider itself tells its value to screen readers.
  const output = h('span', { class: 'value', 'aria-hidden': 'true' }, setting.text(setting.value));
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
 * @param {import('./layer.js').Setting} setting
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
 * @param {import('./layer.js').Setting} setting
 * @param {() => void} onChange
 * @returns {HTMLElement}
 */
function selectBox(layerId, name, setting, onChange) {
  const options = (setting.choices ?? []).map((text, value) => h('option', { value, selected: value === setting.value }, text));
  const select = h('select', { 'data-setting': `${layerId}.${name}` }, ...options);
  select.addEventListener('change', () => {
    setting.value = Number(select.value);
    onChange();
  });
  return h('label', { class: 'field' }, setting.name, select);
}
