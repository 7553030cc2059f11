// The panel of mask edges: grow, feather, specks and smoothing.

import { byId } from '../dom.js';
import { DEFAULT_EDGES } from '../../model/store.js';
import type { EdgeSettings } from '../../model/view-settings.js';
import type { Page } from '../page.js';

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
