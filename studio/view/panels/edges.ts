// Edges of masks: how they grow, shrink and fade, and over how many frames they are smoothed.

import { byId } from '../dom.js';
import { DEFAULT_EDGES } from '../../model/store.js';
import type { EdgeChoice } from '../../model/look.js';
import type { Page } from '../page.js';

const WORDS: { [Name in keyof EdgeChoice]: (value: number) => string } = {
  smallest: (value) => (value > 0 ? `${value.toFixed(2)}\u00a0%` : 'kept'),
  grow: (value) => (value === 0 ? 'as found' : `${value > 0 ? '+' : '−'}${Math.abs(value)}\u00a0px`),
  feather: (value) => (value > 0 ? `${value}\u00a0px` : 'hard'),
  smooth: (value) => (value > 0 ? `±${value}` : 'off'),
};

export function edgesPanel({ store, viewer }: Pick<Page, 'store' | 'viewer'>) {
  const names = Object.keys(WORDS) as (keyof EdgeChoice)[];
  const inputs = names.map((name) => {
    const input = byId<HTMLInputElement>(`edge-${name}`);
    input.addEventListener('input', () => store.set({ edges: { ...store.state.edges, [name]: Number(input.value) } }));
    return { name, input };
  });
  byId('edges-reset').addEventListener('click', () => store.set({ edges: DEFAULT_EDGES }));
  store.watch(['edges', 'smoothed'], ({ edges, smoothed }) => {
    for (const { name, input } of inputs) {
      const [value, min, max] = [edges[name], Number(input.min), Number(input.max)];
      input.value = String(value);
      input.style.setProperty('--share', String((value - min) / (max - min)));
      input.setAttribute('aria-valuetext', WORDS[name](value));
      byId(`edge-${name}-text`).textContent = WORDS[name](value);
      if (name === 'smooth' && smoothed && smoothed.done < smoothed.total)
        byId('edge-smooth-text').textContent += ` · ${Math.floor((100 * smoothed.done) / smoothed.total)}\u00a0%`;
    }
    byId('edges-reset').hidden = names.every((name) => edges[name] === DEFAULT_EDGES[name]);
    viewer.redraw();
  });
}
