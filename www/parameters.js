// The forms of the lab: the package's parameters with their documentation, whose values become session options, and the frames
// of a file with their size.

import { parameters } from 'tracecut';
import { h } from './dom.js';

/** Text of an empty field: the preset decides, and the package does not list the values of presets. */
const BY_PRESET = 'by preset';

export class Parameters {
  /** @type {'default' | 'fast' | 'paper'} */
  preset = 'default';
  /** The values that the user set, by parameter name. */
  values = new Map();
  #rows = [];
  #onChange;

  constructor(onChange) {
    this.#onChange = onChange;
  }

  /** Returns the options for `createSession`. */
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

  /** Builds the list of parameters of the given groups, expert ones last. */
  list(groups) {
    const selected = parameters().filter(({ name }) => groups.includes(name.split('.')[0]));
    const sorted = selected.sort((a, b) => Number(a.expert) - Number(b.expert));
    const rows = sorted.map((parameter) => new Row(parameter, this));
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
    // Backticks enclose code.
    const description = doc.split('`').map((part, k) => (k % 2 === 1 ? h('code', {}, part) : part));
    const range = this.isNumber ? `${min} to ${max}, default ${initial}` : `default ${initial}`;
    this.element = h(
      'div',
      { class: 'parameter' },
      h('label', { for: name }, name),
      this.field,
      h('p', { class: 'range' }, range, ' ', this.reset),
      h('p', { class: 'doc', id: `${name}-doc` }, ...description),
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

  /** Shows the current value. */
  update() {
    const { preset, values } = this.owner;
    const value = values.get(this.parameter.name);
    this.field.value = String(value ?? (preset === 'default' ? this.parameter.default : ''));
    this.reset.hidden = value === undefined;
    this.element.classList.toggle('is-changed', value !== undefined);
    this.#showError('');
  }

  /** Sets the entered value if it is valid. */
  #read() {
    const { name, kind, min, max } = this.parameter;
    const { value, validity } = this.field;
    if (value === '' && !validity.badInput) return this.owner.set(name);
    if (!this.isNumber) return this.owner.set(name, kind === 'boolean' ? value === 'true' : value);
    const isWhole = kind !== 'integer' || Number.isInteger(Number(value));
    const isValid = !validity.badInput && !validity.rangeUnderflow && !validity.rangeOverflow && isWhole;
    if (!isValid) return this.#showError(`Enter a ${kind === 'integer' ? 'whole ' : ''}number, ${min} to ${max}.`);
    this.owner.set(name, Number(value));
  }

  #showError(text) {
    this.error.textContent = text;
    this.field.setAttribute('aria-invalid', String(text !== ''));
  }
}

/** The fields, named like the properties of `DEFAULT_SELECTION`. */
const FIELDS = [
  { name: 'start', text: 'Start (seconds)', min: 0, max: 1e5, step: 'any' },
  { name: 'maxFrames', text: 'Frames', min: 2, max: 200 },
  { name: 'step', text: 'Every nth frame', min: 1, max: 100 },
  { name: 'size', text: 'Long side (pixels)', min: 64, max: 1920 },
];

/** Builds the form; `onChange` receives the whole selection. */
export function selectionForm(onChange) {
  const inputs = FIELDS.map(({ text: _, ...field }) => h('input', { type: 'number', required: true, ...field }));
  const labels = FIELDS.map(({ text }, k) => h('label', {}, text, inputs[k]));
  const element = h('form', { class: 'selection', change, submit: (event) => event.preventDefault() }, ...labels);

  function change() {
    if (element.reportValidity())
      onChange(Object.fromEntries(inputs.map(({ name, valueAsNumber }) => [name, valueAsNumber])));
  }

  /** Shows the selection of a clip; the sample has no choice. */
  function show({ selection, files }) {
    element.hidden = files.length === 0;
    for (const input of inputs) input.value = selection[input.name];
  }
  return { element, show };
}
