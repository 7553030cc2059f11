/** A control for one parameter: a switch, a list, a slider, or a field for numbers. @module */

import { h } from '../dom.js';
import { say } from '../language.js';

/** @typedef {import('../settings.js').Parameter} Parameter */

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
  const legal = kind === 'integer' ? say`a whole number, ${min} to ${max}` : say`${min} to ${max}`;
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
