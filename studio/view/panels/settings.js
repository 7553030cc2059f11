/**
 * Settings: a few that matter first, then more by stage and those for experts; each says what it does, and goes back to
 * its default.
 * @module
 */

import { byId, h, icon } from '../dom.js';
import { ESSENTIALS, GROUPS, labelOf, groupsFor, optionsOf } from '../settings.js';
import { kindOf } from '../source.js';
import { plural } from '../words.js';

/** @typedef {import('../settings.js').Settings} Settings */
/** @typedef {import('../store.js').State} State */
/** @typedef {import('../settings.js').Parameter} Parameter */

/** @param {Pick<import('../page.js').Page, 'store' | 'settings'>} page */
export function settingsPanel({ store, settings }) {
  const few = ESSENTIALS.map(({ name, label, about, range, unit, only }) => ({
    only,
    element: row(settings, name, { label, about, range, unit }),
  }));
  const [shown, expert] = [false, true].map((isExpert) =>
    GROUPS.flatMap((group) => groupOf(settings, group, isExpert)),
  );
  const groups = [...shown, ...expert];
  byId('settings-groups').append(...shown.map(({ element }) => element));
  byId('settings-expert-groups').append(...expert.map(({ element }) => element));
  byId('settings-reset').addEventListener('click', () => settings.resetAll());
  store.watch(['source'], ({ source }) => {
    const wanted = groupsFor(kindOf(source));
    const first = few.filter(({ only }) => only === kindOf(source));
    byId('settings-few').replaceChildren(...first.map(({ element }) => element));
    for (const { element, group } of groups) element.hidden = !wanted(group.id);
  });
  store.watch(['source', 'changed'], showCount);
  store.watch(['phase', 'job', 'take', 'source', 'changed'], (state) => store.set({ pending: isPending(state) }));
  store.watch(['pending'], ({ pending }) => (byId('pending').hidden = !pending));
}

/** @param {Readonly<State>} state */
function showCount({ changed, source }) {
  const wanted = groupsFor(kindOf(source));
  const count = [...changed.keys()].filter((name) => wanted(name.split('.')[0])).length;
  byId('settings-count').textContent = count > 0 ? `${count} changed` : '';
  byId('settings-reset').hidden = changed.size === 0;
  byId('settings-reset').title = plural(changed.size, 'changed setting');
}

/**
 * Whether the result on screen was made with other settings than those chosen now.
 *
 * @param {Readonly<State>} state
 */
function isPending(state) {
  const { phase, job, take } = state;
  return phase === 'done' && job !== null && !job.isFor(take, optionsOf(state));
}

/**
 * The parameters of one stage that are for experts, or those that are not; nothing where there are none. Its rows are
 * built when it is first opened.
 *
 * @param {Settings} settings
 * @param {import('../settings.js').Group} group
 * @param {boolean} isExpert
 */
function groupOf(settings, group, isExpert) {
  const own = [...settings.parameters.values()].filter(({ name }) => name.startsWith(`${group.id}.`));
  const names = own.filter(({ expert }) => expert === isExpert).map(({ name }) => name);
  if (names.length === 0) return [];
  const note = h('span', { class: 'block-note' });
  const rows = h('div', { class: 'settings' });
  let isFilled = false;
  const fill = () => {
    if (isFilled) return;
    isFilled = true;
    rows.append(h('p', { class: 'about' }, group.about));
    for (const name of names)
      rows.append(row(settings, name, { label: labelOf(name), about: settings.parameters.get(name)?.doc ?? '' }));
  };
  const element = h(
    'details',
    { class: 'group', 'data-group': group.id, toggle: fill },
    h('summary', {}, group.title, ' ', note),
    rows,
  );
  settings.store.watch(['changed'], ({ changed }) => {
    const count = names.filter((name) => changed.has(name)).length;
    note.textContent = count > 0 ? `${count} changed` : '';
  });
  return [{ element, group }];
}

/**
 * @param {Settings} settings
 * @param {string} name
 * @param {{label: string, about: string, range?: [number, number, number], unit?: string}} words
 * @returns {HTMLElement}
 */
function row(settings, name, { label, about, range, unit = '' }) {
  const parameter = /** @type {import('../settings.js').Parameter} */ (settings.parameters.get(name));
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
  /** @type {import('../settings.js').Value | undefined} */
  let shown;
  settings.store.watch(['changed'], ({ changed }) => {
    const value = settings.get(name);
    // What is being typed here stays when another setting changes.
    if (value !== shown) control.show(value);
    shown = value;
    element.classList.toggle('is-changed', changed.has(name));
    reset.hidden = !changed.has(name);
  });
  return element;
}

/**
 * @typedef {object} Control
 * @property {HTMLElement} element
 * @property {HTMLInputElement | HTMLSelectElement} input
 * @property {(value: number | boolean | string) => void} show
 */

/**
 * @typedef {object} Wiring
 * @property {string} id of the input
 * @property {[min: number, max: number, step: number]} [range] of a slider
 * @property {string} unit
 * @property {(value: number | boolean | string) => boolean} set false where the value is not legal
 */

/** Most values that a slider is made for; a wider range gets a field. */
const SLIDER_STEPS = 128;

/**
 * @param {Parameter} parameter
 * @param {Wiring} wiring
 * @returns {Control}
 */
export function controlOf(parameter, wiring) {
  if (parameter.kind === 'boolean') return toggle(wiring);
  if (parameter.kind === 'choice') return list(parameter, wiring);
  const range = wiring.range ?? sliderRange(parameter);
  return range ? slider(range, wiring) : field(parameter, wiring);
}

/**
 * @param {Parameter} parameter
 * @returns {[number, number, number] | undefined} where the range is narrow enough for a slider
 */
function sliderRange({ kind, min, max }) {
  const step = kind === 'integer' ? 1 : 0.01;
  return (max - min) / step <= SLIDER_STEPS ? [min, max, step] : undefined;
}

/**
 * @param {Wiring} wiring
 * @returns {Control}
 */
function toggle({ id, set }) {
  const input = h('input', { type: 'checkbox', role: 'switch', class: 'switch', id });
  input.addEventListener('change', () => set(input.checked));
  return {
    element: h('span', { class: 'setting-control' }, input),
    input,
    show: (value) => (input.checked = value === true),
  };
}

/**
 * @param {Parameter} parameter
 * @param {Wiring} wiring
 * @returns {Control}
 */
function list({ choices = [] }, { id, set }) {
  const input = h('select', { id }, ...choices.map((name) => h('option', { value: name }, name)));
  input.addEventListener('change', () => set(input.value));
  return {
    element: h('span', { class: 'setting-control' }, input),
    input,
    show: (value) => (input.value = String(value)),
  };
}

/**
 * @param {[number, number, number]} range
 * @param {Wiring} wiring
 * @returns {Control}
 */
function slider([min, max, step], { id, unit, set }) {
  const input = h('input', { type: 'range', id, min, max, step });
  const output = h('span', { class: 'value', 'aria-hidden': 'true' });
  input.addEventListener('input', () => set(Number(input.value)));
  const show = (/** @type {number | boolean | string} */ value) => {
    const text = unit ? `${value}\u00a0${unit}` : String(value);
    input.value = String(value);
    input.style.setProperty('--share', String(Math.min(1, Math.max(0, (Number(value) - min) / (max - min)))));
    input.setAttribute('aria-valuetext', text);
    output.textContent = text;
  };
  return { element: h('span', { class: 'setting-control setting-slider' }, input, output), input, show };
}

/**
 * @param {Parameter} parameter
 * @param {Wiring} wiring
 * @returns {Control}
 */
function field({ kind, min, max }, { id, set }) {
  const input = h('input', {
    type: 'number',
    id,
    min,
    max,
    step: kind === 'integer' ? 1 : 'any',
    inputmode: 'decimal',
  });
  const legal = kind === 'integer' ? `a whole number, ${min} to ${max}` : `${min} to ${max}`;
  const note = h('span', { class: 'value' }, legal);
  const tell = (/** @type {boolean} */ fine) => {
    input.setAttribute('aria-invalid', String(!fine));
    note.classList.toggle('is-wrong', !fine);
  };
  input.addEventListener('input', () => tell(input.value !== '' && set(Number(input.value))));
  const show = (/** @type {number | boolean | string} */ value) => {
    // What is being typed stays as it is.
    if (Number(input.value) !== value || input.value === '') input.value = String(value);
    tell(true);
  };
  return { element: h('span', { class: 'setting-control setting-field' }, input, note), input, show };
}
