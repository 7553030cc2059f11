// The list of layers: a switch, a key and, for layers that are on, their settings.

import { byId, h } from '../dom.js';
import type { Layer, Setting } from '../layers.js';
import type { Page } from '../page.js';

export function layersPanel({ layers, viewer, keys }: Pick<Page, 'layers' | 'viewer' | 'keys'>) {
  for (const layer of layers) {
    const { element, box } = layerRow(layer, () => viewer.redraw());
    byId('layer-list').append(element);
    keys.on(layer.key, () => box.click());
  }
}

function layerRow(layer: Layer, onChange: () => void) {
  const box = h('input', {
    type: 'checkbox',
    role: 'switch',
    class: 'switch',
    'data-layer': layer.id,
    'aria-keyshortcuts': layer.key,
  });
  box.checked = layer.isOn;
  const details = h(
    'div',
    { class: 'layer-details' },
    h('p', { class: 'about' }, layer.about),
    ...Object.entries(layer.settings).map(([name, setting]) => slider(layer.id, name, setting, onChange)),
  );
  const refresh = () => (details.hidden = !layer.isOn);
  box.addEventListener('change', () => {
    layer.isOn = box.checked;
    refresh();
    onChange();
  });
  refresh();
  const key = h('kbd', { title: 'Key', 'aria-hidden': 'true' }, layer.key);
  const label = h('label', { class: 'layer-name' }, box, h('span', {}, layer.name), key);
  const element = h('li', { class: 'layer' }, label, details);
  return { box, element };
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
