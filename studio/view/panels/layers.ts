// How the picture looks: its layers, each with a switch, a key and settings, the edges of masks, and texts about the picture.

import { byId, h } from '../dom.js';
import { DEFAULT_EDGES, type State } from '../../model/store.js';
import { describeFrame } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import type { Layer, Setting } from '../layers.js';
import type { Page } from '../page.js';
import type { EdgeSettings } from '../../model/view-settings.js';

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

const WORDS: { [Name in keyof EdgeSettings]: (value: number) => string } = {
  smallest: (value) => (value > 0 ? `${value.toFixed(2)}%` : 'off'),
  grow: (value) => (value === 0 ? '0\u00a0px' : `${value > 0 ? '+' : '−'}${Math.abs(value)}\u00a0px`),
  feather: (value) => (value > 0 ? `${value}\u00a0px` : 'hard'),
  smooth: (value) => (value > 0 ? `±${value}` : 'off'),
};

export function edgesPanel({ store, viewer }: Pick<Page, 'store' | 'viewer'>) {
  const names = Object.keys(WORDS) as (keyof EdgeSettings)[];
  const inputs = names.map((name) => {
    const input = byId<HTMLInputElement>(`edge-${name}`);
    input.addEventListener('input', () => store.set({ edges: { ...store.state.edges, [name]: Number(input.value) } }));
    return { name, input };
  });
  byId('edges-reset').addEventListener('click', () => store.set({ edges: DEFAULT_EDGES }));
  store.watch(['edges', 'smoothedMasks'], ({ edges, smoothedMasks }) => {
    for (const { name, input } of inputs) {
      const [value, min, max] = [edges[name], Number(input.min), Number(input.max)];
      input.value = String(value);
      input.style.setProperty('--share', String((value - min) / (max - min)));
      input.setAttribute('aria-valuetext', WORDS[name](value));
      byId(`edge-${name}-text`).textContent = WORDS[name](value);
      if (name === 'smooth' && smoothedMasks && smoothedMasks.done < smoothedMasks.total)
        byId('edge-smooth-text').textContent += ` · ${Math.floor((100 * smoothedMasks.done) / smoothedMasks.total)}%`;
    }
    byId('edges-reset').hidden = names.every((name) => edges[name] === DEFAULT_EDGES[name]);
    viewer.redraw();
  });
}

/** Time on one frame before it is described, in milliseconds; chosen by eye. */
const REST_MS = 250;

export function readoutPanel({ store }: Pick<Page, 'store'>) {
  store.watch(['spot'], ({ spot, analysis }) => {
    const isNamed = analysis !== null && spot.object >= 0;
    byId('readout').hidden = !isNamed;
    if (isNamed) byId('readout').textContent = objectName(spot.object);
  });
  let resting = 0;
  store.watch(['frame', 'timeline'], () => {
    clearTimeout(resting);
    resting = window.setTimeout(() => showFrameText(store.state), REST_MS);
  });
  store.watch(['analysis'], showFrameText);
  store.watch(['phase', 'headline', 'source'], labelCanvas);
}

/** Describes the frame on screen for screen readers. */
function showFrameText({ analysis, frame, timeline }: Readonly<State>) {
  const segmentation = analysis?.segmentation;
  byId('frame-text').textContent = segmentation
    ? describeFrame(segmentation.presence, segmentation.count, frame, timeline.times)
    : '';
}

function labelCanvas({ phase, headline, source }: Readonly<State>) {
  const label = phase === 'done' && source ? `${source.name}: ${headline}` : 'No result yet';
  byId('canvas').setAttribute('aria-label', label);
}
