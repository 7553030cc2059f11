// Which frames of a file are taken, and how large they are.

import { h } from './dom.js';

/** @typedef {import('./clip.js').Take} Take */

/** @type {readonly {name: keyof Take, text: string, min: number, max: number, step: number | 'any'}[]} */
const FIELDS = [
  { name: 'start', text: 'Start, seconds', min: 0, max: 1e5, step: 'any' },
  { name: 'maxFrames', text: 'Frames', min: 2, max: 200, step: 1 },
  { name: 'step', text: 'Take every nth', min: 1, max: 100, step: 1 },
  { name: 'size', text: 'Long side, pixels', min: 64, max: 1920, step: 1 },
];

/**
 * Builds the form.
 * @param {(take: Take) => void} onChange
 * @returns {{element: HTMLElement, show: (take: Take, isFile: boolean) => void}}
 */
export function takeForm(onChange) {
  const inputs = FIELDS.map(({ name, min, max, step }) =>
    h('input', { type: 'number', name, min, max, step, required: true }),
  );
  const form = h(
    'form',
    { class: 'take', change: read, submit: (event) => event.preventDefault() },
    ...FIELDS.map(({ text }, k) => h('label', {}, text, /** @type {HTMLInputElement} */ (inputs[k]))),
  );

  function read() {
    if (!form.reportValidity()) return;
    const values = inputs.map((input) => [input.name, input.valueAsNumber]);
    onChange(/** @type {Take} */ (Object.fromEntries(values)));
  }

  /** @type {(take: Take, isFile: boolean) => void} */
  function show(take, isFile) {
    form.hidden = !isFile;
    for (const input of inputs) input.value = String(take[/** @type {keyof Take} */ (input.name)]);
  }
  return { element: form, show };
}
