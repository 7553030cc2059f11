/** The panel of settings: the few that matter first, then all of them by stage, each with its meaning and a reset. @module */

import { byId, h, icon } from './dom.js';
import { ESSENTIALS, GROUPS, labelOf } from './settings-words.js';
import { controlOf } from './settings-controls.js';
import { plural } from './words.js';

/** @typedef {import('./settings.js').Settings} Settings */

export class SettingsPanel {
  /** @param {Settings} settings */
  constructor(settings) {
    this.settings = settings;
    /** @type {'clip' | 'still'} */
    this.kind = 'clip';
    byId('settings-reset').addEventListener('click', () => settings.resetAll());
    this.groups = GROUPS.map((group) => groupOf(settings, group));
    byId('settings-groups').append(...this.groups.map(({ element }) => element));
    settings.addEventListener('change', () => this.update());
    this.setKind('clip');
  }

  /** @param {'clip' | 'still'} kind of source: settings that do nothing for it are not shown */
  setKind(kind) {
    this.kind = kind;
    const few = ESSENTIALS.filter(({ only }) => only === kind);
    byId('settings-few').replaceChildren(
      ...few.map(({ name, label, about, range, unit }) => row(this.settings, name, { label, about, range, unit })),
    );
    for (const { element, group } of this.groups) element.hidden = !countsFor(group, kind);
    this.update();
  }

  /** @returns {(group: string) => boolean} which groups count for this kind of source */
  get wanted() {
    const ids = GROUPS.filter((group) => countsFor(group, this.kind)).map(({ id }) => id);
    return (id) => ids.includes(id);
  }

  update() {
    const { settings, wanted } = this;
    const count = [...settings.changed.keys()].filter((name) => wanted(name.split('.')[0])).length;
    byId('settings-count').textContent = count > 0 ? `${count} changed` : '';
    byId('settings-reset').hidden = settings.changed.size === 0;
    byId('settings-reset').title = plural(settings.changed.size, 'changed setting');
    for (const { update } of this.groups) update();
  }
}

/**
 * @param {import('./settings-words.js').Group} group
 * @param {'clip' | 'still'} kind
 */
function countsFor({ only }, kind) {
  return (only ?? kind) === kind;
}

/**
 * One stage. Its rows are built when it is first opened.
 *
 * @param {Settings} settings
 * @param {import('./settings-words.js').Group} group
 */
function groupOf(settings, group) {
  const names = [...settings.parameters.keys()].filter((name) => name.startsWith(`${group.id}.`));
  const note = h('span', { class: 'block-note' });
  const rows = h('div', { class: 'settings' });
  const fill = () => {
    if (rows.childElementCount > 0) return;
    rows.append(h('p', { class: 'about' }, group.about));
    for (const name of names) rows.append(row(settings, name, { label: labelOf(name), about: settings.parameters.get(name)?.doc ?? '' }));
  };
  const element = h('details', { class: 'group', 'data-group': group.id, toggle: fill }, h('summary', {}, group.title, ' ', note), rows);
  const update = () => {
    const count = names.filter((name) => settings.changed.has(name)).length;
    note.textContent = count > 0 ? `${count} changed` : '';
  };
  return { element, group, update };
}

/**
 * @param {Settings} settings
 * @param {string} name
 * @param {{label: string, about: string, range?: [number, number, number], unit?: string}} words
 * @returns {HTMLElement}
 */
function row(settings, name, { label, about, range, unit = '' }) {
  const parameter = /** @type {import('./settings.js').Parameter} */ (settings.parameters.get(name));
  const id = `setting-${range ? 'few' : 'all'}-${name.replace('.', '-')}`;
  const control = controlOf(parameter, { id, range, unit, set: (value) => settings.set(name, value) });
  const reset = h(
    'button',
    {
      type: 'button',
      class: 'icon-button reset',
      'aria-label': `Reset ${label}`,
      title: `Back to ${parameter.default}`,
      click: () => {
        settings.reset(name);
        control.input.focus();
      },
    },
    icon('icon-reset'),
  );
  const element = h(
    'div',
    { class: 'setting', 'data-parameter': name },
    h('label', { class: 'setting-name', for: id }, label),
    reset,
    control.element,
    h('p', { class: 'about', id: `${id}-about` }, about),
  );
  control.input.setAttribute('aria-describedby', `${id}-about`);
  const update = () => {
    control.show(settings.get(name));
    const changed = settings.changed.has(name);
    element.classList.toggle('is-changed', changed);
    reset.hidden = !changed;
  };
  settings.addEventListener('change', (event) => {
    if (/** @type {CustomEvent} */ (event).detail === name) update();
  });
  update();
  return element;
}
