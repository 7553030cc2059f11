// The sheet that makes a result again with other settings.

import { byId, connectDialog, h } from '../dom.js';
import {
  SETTING_CHOICES,
  type SettingChoice,
  type Settings,
  otherChanges,
  sessionOptions,
} from '../../model/settings.js';
import { formatPlural } from '../../model/messages.js';
import type { State } from '../../model/store.js';
import type { Page } from '../page.js';

export function settingsPanel({ app, store, settings }: Pick<Page, 'app' | 'store' | 'settings'>) {
  const dialog = byId<HTMLDialogElement>('redo');
  connectDialog(dialog);
  byId('redo-open').addEventListener('click', () => dialog.showModal());
  byId('redo-close').addEventListener('click', () => dialog.close());
  byId('redo-run').addEventListener('click', () => {
    dialog.close();
    void app.rerun();
  });
  byId('settings-list').append(...SETTING_CHOICES.map((choice) => createRow(settings, choice)));
  byId('settings-reset').addEventListener('click', () => settings.resetAll());
  store.watch(['changed'], showChanged);
  store.watch(['phase', 'job', 'trim', 'changed'], (state) => store.set({ isOutdated: isPending(state) }));
  store.watch(['isOutdated'], ({ isOutdated }) => document.body.toggleAttribute('data-outdated', isOutdated));
}

function showChanged(state: Readonly<State>) {
  const others = otherChanges(state);
  byId('settings-others').hidden = others.length === 0;
  byId('settings-others').textContent = `Also changed: ${others.join(', ')}.`;
  byId('settings-reset').hidden = state.changed.size === 0;
  byId('settings-reset').title = formatPlural(state.changed.size, 'changed setting');
}

/** Returns whether the settings have changed since the run. */
function isPending(state: Readonly<State>) {
  const { phase, job, trim } = state;
  return phase === 'done' && job !== null && !job.hasSettings(trim, sessionOptions(state));
}

function createRow(settings: Settings, { name, label, options }: SettingChoice): HTMLElement {
  const radios = options.map(({ label: text, value }) => {
    const input = h('input', { type: 'radio', name, value: value ?? 'default' });
    input.addEventListener('input', () => (value === null ? settings.reset(name) : settings.set(name, value)));
    return { value, input, element: h('label', {}, input, h('span', {}, text)) };
  });
  settings.store.watch(['changed'], ({ changed }) => {
    for (const { value, input } of radios) input.checked = (changed.get(name) ?? null) === value;
  });
  return h(
    'fieldset',
    { class: 'setting', 'data-parameter': name },
    h('legend', {}, label),
    h('span', { class: 'segmented' }, ...radios.map(({ element }) => element)),
  );
}
