// The parameters of the package with their documentation, grouped by stage; changed values become session options.

import { parameters } from 'tracecut';
import { h, number } from './dom.js';

/** @typedef {import('tracecut').Parameter} Parameter */
/** @typedef {string | number | boolean} Value */

/** A field that is empty with this text has the value that the preset gives it, which the package does not list. */
const BY_PRESET = 'by preset';

export class Parameters {
  /** @type {'default' | 'fast' | 'paper'} */
  preset = 'default';
  /** @type {Map<string, Value>} Values that the user has set. */
  values = new Map();
  /** @type {Row[]} */
  #rows = [];
  #onChange;

  /** @param {() => void} onChange called after each change */
  constructor(onChange) {
    this.#onChange = onChange;
  }

  /** The tree that `createSession` takes. */
  options() {
    /** @type {Record<string, Record<string, Value>>} */
    const tree = {};
    for (const [name, value] of this.values) {
      const [group = '', field = ''] = name.split('.');
      (tree[group] ??= {})[field] = value;
    }
    return /** @type {import('tracecut').SessionOptions} */ ({ preset: this.preset, ...tree });
  }

  /** @param {'default' | 'fast' | 'paper'} preset */
  choosePreset(preset) {
    this.preset = preset;
    this.#update();
  }

  reset() {
    this.preset = 'default';
    this.values.clear();
    this.#update();
  }

  /**
   * Sets a parameter, or leaves it to the preset.
   * @param {string} name
   * @param {Value | undefined} value
   */
  set(name, value) {
    if (value === undefined) this.values.delete(name);
    else this.values.set(name, value);
    this.#update();
  }

  /**
   * Builds the list of the parameters of some groups; those that only research changes come last.
   * @param {string[]} groups
   */
  list(groups) {
    const wanted = parameters().filter(({ name }) => groups.includes(String(name.split('.')[0])));
    const sorted = [...wanted.filter(({ expert }) => !expert), ...wanted.filter(({ expert }) => expert)];
    const rows = sorted.map((parameter) => new Row(parameter, this));
    this.#rows.push(...rows);
    return h(
      'details',
      { class: 'parameters' },
      h('summary', {}, `Parameters (${rows.length})`),
      ...rows.map(({ element }) => element),
    );
  }

  #update() {
    for (const row of this.#rows) row.update();
    this.#onChange();
  }
}

/** One parameter: its name, a field, its range and its documentation. */
class Row {
  /**
   * @param {Parameter} parameter
   * @param {Parameters} owner
   */
  constructor(parameter, owner) {
    const { name, doc, kind, min, max } = parameter;
    this.parameter = parameter;
    this.owner = owner;
    this.field = this.#field();
    this.error = h('p', { class: 'invalid', role: 'alert' });
    this.resetButton = h(
      'button',
      { type: 'button', class: 'link', 'aria-label': `Reset ${name}`, click: () => owner.set(name, undefined) },
      'Reset',
    );
    const range = kind === 'number' || kind === 'integer' ? `${plain(min)} to ${plain(max)}, ` : '';
    this.element = h(
      'div',
      { class: 'parameter' },
      h('label', { for: name }, name),
      this.field,
      h('p', { class: 'range' }, `${range}default ${plain(parameter.default)}`, ' ', this.resetButton),
      h('p', { id: `${name}-doc`, class: 'doc' }, ...withCode(doc)),
      this.error,
    );
    this.update();
  }

  #field() {
    const { name, kind, min, max, choices } = this.parameter;
    const common = { id: name, 'aria-describedby': `${name}-doc`, change: () => this.#read() };
    if (kind === 'number' || kind === 'integer')
      return h('input', { ...common, type: 'number', min, max, step: stepOf(this.parameter), placeholder: BY_PRESET });
    const options = ['', ...(choices ?? ['true', 'false'])].map((value) => h('option', { value }, value || BY_PRESET));
    return h('select', common, ...options);
  }

  /** Shows the value that is in force. */
  update() {
    const { name, default: initial } = this.parameter;
    const [own, byPreset] = [this.owner.values.get(name), this.owner.preset !== 'default'];
    this.field.value = String(own ?? (byPreset ? '' : initial));
    if (this.field instanceof HTMLSelectElement)
      /** @type {HTMLOptionElement} */ (this.field.options[0]).hidden = !byPreset;
    this.resetButton.hidden = own === undefined;
    this.element.classList.toggle('is-changed', own !== undefined);
    this.#complain('');
  }

  /** Takes what the user has entered, if it is legal. */
  #read() {
    const { name, kind, min, max } = this.parameter;
    const { value } = this.field;
    const isNumber = kind === 'number' || kind === 'integer';
    if (value === '' && this.field.validity.badInput) return this.#complain('Enter a number.');
    if (value === '') return this.owner.set(name, undefined);
    if (!isNumber) return this.owner.set(name, kind === 'boolean' ? value === 'true' : value);
    const entered = Number(value);
    if (entered < min || entered > max) return this.#complain(`Enter ${plain(min)} to ${plain(max)}.`);
    if (kind === 'integer' && !Number.isInteger(entered)) return this.#complain('Enter a whole number.');
    this.owner.set(name, entered);
  }

  /** @param {string} text */
  #complain(text) {
    this.error.textContent = text;
    this.field.setAttribute('aria-invalid', String(text !== ''));
  }
}

/** Chooses the step of a field's arrows: a tenth of the order of magnitude of the default. @param {Parameter} parameter */
function stepOf({ kind, default: initial, max }) {
  if (kind === 'integer') return 1;
  return 10 ** (Math.floor(Math.log10(Number(initial) || max)) - 1);
}

/** @param {Value} value */
function plain(value) {
  return typeof value === 'number'
    ? number(value, Number.isInteger(value) ? 0 : String(value).split('.')[1]?.length)
    : String(value);
}

/** Splits documentation at its backticks. @param {string} doc */
function withCode(doc) {
  return doc.split('`').map((part, k) => (k % 2 === 1 ? h('code', {}, part) : part));
}
