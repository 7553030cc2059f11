// The list of layers: a switch, a key and, for layers that are on, the legend and their settings.

import { byId, h } from '../dom.js';
import { kindOf } from '../../model/source.js';
import type { Layer, Setting } from '../layers/layer.js';
import type { Page } from '../page.js';

export function layersPanel({ store, layers, viewer, keys }: Pick<Page, 'store' | 'layers' | 'viewer' | 'keys'>) {
  const rows = layers.map((layer) => layerRow(layer, () => viewer.redraw()));
  byId('layer-list').append(...rows.map(({ element }) => element));
  for (const { layer, box } of rows)
    keys.on(
      layer.key,
      () => box.click(),
      () => isFor(layer, kindOf(store.state.source)),
    );
  store.watch(['source'], ({ source }) => {
    for (const { layer, element } of rows) element.hidden = !isFor(layer, kindOf(source));
  });
}

function isFor(layer: Layer, kind: 'clip' | 'still') {
  return (layer.only ?? kind) === kind;
}

function layerRow(layer: Layer, onChange: () => void) {
  const box = h('input', {
    type: 'checkbox',
    role: 'switch',
    class: 'switch',
    'data-layer': layer.id,
    'aria-keyshortcuts': layer.key,
  });
  box.checked = layer.on;
  const legend = h('div', { class: 'legend' }, ...layer.legend());
  const details = h(
    'div',
    { class: 'layer-details' },
    h('p', { class: 'about' }, layer.about),
    legend,
    ...Object.entries(layer.settings).map(([name, setting]) => controlOf(setting)(layer.id, name, setting, onChange)),
  );
  legend.hidden = layer.legend().length === 0;
  const refresh = () => (details.hidden = !layer.on);
  box.addEventListener('change', () => {
    layer.on = box.checked;
    refresh();
    onChange();
  });
  refresh();
  const key = h('kbd', { title: 'Key', 'aria-hidden': 'true' }, layer.key);
  const label = h('label', { class: 'layer-name' }, box, h('span', {}, layer.name), key);
  const element = h('li', { class: 'layer' }, label, details);
  return { layer, box, element };
}

function controlOf(setting: Setting) {
  if (setting.choices) return selectBox;
  return setting.toggle ? miniSwitch : slider;
}

function slider(layerId: string, name: string, setting: Setting, onChange: () => void): HTMLElement {
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

function miniSwitch(layerId: string, name: string, setting: Setting, onChange: () => void): HTMLElement {
  const box = h('input', { type: 'checkbox', role: 'switch', class: 'switch', 'data-setting': `${layerId}.${name}` });
  box.checked = setting.value > 0;
  box.addEventListener('change', () => {
    setting.value = box.checked ? 1 : 0;
    onChange();
  });
  return h('label', { class: 'toggle' }, h('span', {}, setting.name), box);
}

function selectBox(layerId: string, name: string, setting: Setting, onChange: () => void): HTMLElement {
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
