/** The list of layers: a switch, a key and, for layers that are on, the legend and their settings. @module */

import { byId, h } from './dom.js';

/** @typedef {import('./layer.js').Layer} Layer */

/**
 * @param {Layer[]} layers
 * @param {() => void} onChange
 * @returns {{toggle: (index: number) => void}}
 */
export function layersPanel(layers, onChange) {
  const rows = layers.map((layer, index) => layerRow(layer, index, onChange));
  byId('layer-list').replaceChildren(...rows.map((row) => row.element));
  byId('last-layer').textContent = String(Math.min(9, layers.length));
  return {
    toggle(index) {
      const box = rows[index]?.box;
      if (box) box.click();
    },
  };
}

/**
 * @param {Layer} layer
 * @param {number} index
 * @param {() => void} onChange
 */
function layerRow(layer, index, onChange) {
  const shortcut = String(index + 1);
  const box = h('input', {
    type: 'checkbox',
    role: 'switch',
    class: 'switch',
    'data-layer': layer.id,
    'aria-keyshortcuts': shortcut,
  });
  box.checked = layer.on;
  const legend = h('div', { class: 'legend' });
  const details = h(
    'div',
    { class: 'layer-details' },
    h('p', { class: 'about' }, layer.about),
    legend,
    ...Object.entries(layer.settings).map(([name, setting]) => (setting.toggle ? miniSwitch : slider)(layer.id, name, setting, onChange)),
  );
  const refresh = () => {
    layer.on = box.checked;
    details.hidden = !layer.on;
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
  return { box, element: h('li', { class: 'layer' }, label, details) };
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
