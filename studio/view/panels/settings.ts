// The panel of the main settings.

import { byId, h, icon } from '../dom.js';
import { ESSENTIALS, type Essential, type Settings, appliesTo, sessionOptions } from '../../model/settings.js';
import { sourceKind } from '../../model/source.js';
import { formatPlural } from '../../model/messages.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

export function settingsPanel({ store, settings }: Pick<Page, 'store' | 'settings'>) {
  const rows = ESSENTIALS.map((essential) => ({ only: essential.only, element: createRow(settings, essential) }));
  byId('settings-reset').addEventListener('click', () => settings.resetAll());
  store.watch(['source'], ({ source }) => {
    const shownRows = rows.filter(({ only }) => only === sourceKind(source));
    byId('settings-list').replaceChildren(...shownRows.map(({ element }) => element));
  });
  store.watch(['source', 'changed'], showChanged);
  store.watch(['phase', 'job', 'trim', 'source', 'changed'], (state) => store.set({ isOutdated: isPending(state) }));
  store.watch(['isOutdated'], ({ isOutdated }) => (byId('outdated').hidden = !isOutdated));
}

function showChanged({ changed, source }: Readonly<State>) {
  const hiddenChanges = [...changed]
    .filter(([name]) => appliesTo(source, name) && !ESSENTIALS.some((essential) => essential.name === name))
    .map(([name, value]) => `${name} = ${value}`);
  byId('settings-others').hidden = hiddenChanges.length === 0;
  byId('settings-others').textContent = `Also changed: ${hiddenChanges.join(', ')}.`;
  byId('settings-reset').hidden = changed.size === 0;
  byId('settings-reset').title = formatPlural(changed.size, 'changed setting');
}

/** Returns whether the settings have changed since the run. */
function isPending(state: Readonly<State>) {
  const { phase, job, trim } = state;
  return phase === 'done' && job !== null && !job.hasSettings(trim, sessionOptions(state));
}

function createRow(settings: Settings, { name, label, about, range: [min, max, step], unit }: Essential): HTMLElement {
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
      title: `Reset to ${settings.parameters.get(name)?.default}`,
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
