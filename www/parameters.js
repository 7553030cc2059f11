// The parameters of the package with their documentation; values that the user has set become session options.

import { parameters } from 'tracecut';
import { h } from './dom.js';

/** What an empty field says: the preset decides, and the package does not list its values. */
const BY_PRESET = 'by preset';

export class Parameters {
  /** @type {'default' | 'fast' | 'paper'} */
  preset = 'default';
  /** Values by the names of their parameters. */
  values = new Map();
  #rows = [];
  #onChange;

  constructor(onChange) {
    this.#onChange = onChange;
  }

  /** Returns what `createSession` takes. */
  options() {
    const tree = {};
    for (const [name, value] of this.values) {
      const [group, field] = name.split('.');
      tree[group] = { ...tree[group], [field]: value };
    }
    return { preset: this.preset, ...tree };
  }

  choosePreset(preset) {
    this.preset = preset;
    this.#update();
  }

  reset() {
    this.values.clear();
    this.choosePreset('default');
  }

  /** Sets a parameter; without a value the preset decides. */
  set(name, value) {
    if (value === undefined) this.values.delete(name);
    else this.values.set(name, value);
    this.#update();
  }

  /** Builds the list of the parameters of some groups; those that only research changes come last. */
  list(groups) {
    const wanted = parameters().filter(({ name }) => groups.includes(name.split('.')[0]));
    const rows = wanted.sort((a, b) => Number(a.expert) - Number(b.expert)).map((one) => new Row(one, this));
    this.#rows.push(...rows);
    const summary = h('summary', {}, `Parameters (${rows.length})`);
    return h('details', {}, summary, ...rows.map(({ element }) => element));
  }

  #update() {
    for (const row of this.#rows) row.update();
    this.#onChange();
  }
}

/** One parameter: its name, field, range and documentation. */
class Row {
  /** @param {import('tracecut').Parameter} parameter @param {Parameters} owner */
  constructor(parameter, owner) {
    const { name, doc, min, max, default: initial } = parameter;
    this.parameter = parameter;
    this.owner = owner;
    this.isNumber = typeof initial === 'number';
    this.field = this.#field();
    this.error = h('p', { class: 'invalid', role: 'alert' });
    const reset = { type: 'button', class: 'link', 'aria-label': `Reset ${name}`, click: () => owner.set(name) };
    this.reset = h('button', reset, 'Reset');
    // Backticks set code apart.
    const words = doc.split('`').map((part, k) => (k % 2 === 1 ? h('code', {}, part) : part));
    const range = this.isNumber ? `${min} to ${max}, default ${initial}` : `default ${initial}`;
    this.element = h(
      'div',
      { class: 'parameter' },
      h('label', { for: name }, name),
      this.field,
      h('p', { class: 'range' }, range, ' ', this.reset),
      h('p', { class: 'doc', id: `${name}-doc` }, ...words),
      this.error,
    );
    this.update();
  }

  #field() {
    const { name, kind, min, max, choices = ['true', 'false'], default: initial } = this.parameter;
    const common = { id: name, 'aria-describedby': `${name}-doc`, change: () => this.#read() };
    if (!this.isNumber)
      return h('select', common, ...['', ...choices].map((value) => h('option', { value }, value || BY_PRESET)));
    // A tenth of the order of magnitude.
    const step = kind === 'integer' ? 1 : 10 ** (Math.floor(Math.log10(Number(initial) || max)) - 1);
    return h('input', { ...common, type: 'number', min, max, step, placeholder: BY_PRESET });
  }

  /** Shows the value in force. */
  update() {
    const { preset, values } = this.owner;
    const own = values.get(this.parameter.name);
    this.field.value = String(own ?? (preset === 'default' ? this.parameter.default : ''));
    this.reset.hidden = own === undefined;
    this.element.classList.toggle('is-changed', own !== undefined);
    this.#complain('');
  }

  /** Takes what the user has entered, if it is legal. */
  #read() {
    const { name, kind, min, max } = this.parameter;
    const { value, validity } = this.field;
    if (value === '' && !validity.badInput) return this.owner.set(name);
    if (!this.isNumber) return this.owner.set(name, kind === 'boolean' ? value === 'true' : value);
    const isWhole = kind !== 'integer' || Number.isInteger(Number(value));
    const isLegal = !validity.badInput && !validity.rangeUnderflow && !validity.rangeOverflow && isWhole;
    if (!isLegal) return this.#complain(`Enter a ${kind === 'integer' ? 'whole ' : ''}number, ${min} to ${max}.`);
    this.owner.set(name, Number(value));
  }

  #complain(text) {
    this.error.textContent = text;
    this.field.setAttribute('aria-invalid', String(text !== ''));
  }
}
