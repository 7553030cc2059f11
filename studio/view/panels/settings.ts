// The few settings that an editor cares for: each says what it does, and goes back to its default.

import { byId, h, icon } from '../dom.js';
import { ESSENTIALS, type Essential, type Settings, counts, optionsOf } from '../../model/settings.js';
import { kindOf } from '../../model/source.js';
import { plural } from '../../model/words.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

export function settingsPanel({ store, settings }: Pick<Page, 'store' | 'settings'>) {
  const rows = ESSENTIALS.map((essential) => ({ only: essential.only, element: row(settings, essential) }));
  byId('settings-reset').addEventListener('click', () => settings.resetAll());
  store.watch(['source'], ({ source }) => {
    const wanted = rows.filter(({ only }) => only === kindOf(source));
    byId('settings-few').replaceChildren(...wanted.map(({ element }) => element));
  });
  store.watch(['source', 'changed'], showChanged);
  store.watch(['phase', 'job', 'take', 'source', 'changed'], (state) => store.set({ pending: isPending(state) }));
  store.watch(['pending'], ({ pending }) => (byId('pending').hidden = !pending));
}

function showChanged({ changed, source }: Readonly<State>) {
  const others = [...changed]
    .filter(([name]) => counts(source, name) && !ESSENTIALS.some((essential) => essential.name === name))
    .map(([name, value]) => `${name} = ${value}`);
  byId('settings-others').hidden = others.length === 0;
  byId('settings-others').textContent = `Also changed: ${others.join(', ')}.`;
  byId('settings-reset').hidden = changed.size === 0;
  byId('settings-reset').title = plural(changed.size, 'changed setting');
}

/** Whether the result on screen was made with other settings than those chosen now. */
function isPending(state: Readonly<State>) {
  const { phase, job, take } = state;
  return phase === 'done' && job !== null && !job.isFor(take, optionsOf(state));
}

function row(settings: Settings, { name, label, about, range: [min, max, step], unit }: Essential): HTMLElement {
  const id = `setting-${name.replace('.', '-')}`;
  const input = h('input', { type: 'range', id, min, max, step, 'aria-describedby': `${id}-about` });
  input.addEventListener('input', () => settings.set(name, Number(input.value)));
  const output = h('span', { class: 'value', 'aria-hidden': 'true' });
  const reset = h(
    'button',
    {
      type: 'button',
      class: 'icon-button reset',
      'aria-label': `Reset ${label}`,
      title: `Back to ${settings.parameters.get(name)?.default}`,
      click: () => {
        settings.reset(name);
        input.focus();
      },
    },
    icon('icon-reset'),
  );
  const element = h(
    'div',
    { class: 'setting', 'data-parameter': name },
    h('label', { class: 'setting-name', for: id }, label),
    reset,
    h('span', { class: 'setting-control' }, input, output),
    h('p', { class: 'about', id: `${id}-about` }, about),
  );
  settings.store.watch(['changed'], ({ changed }) => {
    const value = Number(settings.get(name));
    const text = unit ? `${value}\u00a0${unit}` : String(value);
    input.value = String(value);
    input.style.setProperty('--share', String(Math.min(1, Math.max(0, (value - min) / (max - min)))));
    input.setAttribute('aria-valuetext', text);
    output.textContent = text;
    element.classList.toggle('is-changed', changed.has(name));
    reset.hidden = !changed.has(name);
  });
  return element;
}
