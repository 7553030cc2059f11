// The form that says which frames of a file are taken, and how large they are.

import { h } from './dom.js';

/** The fields by the names of the take's parts; see `DEFAULT_TAKE`. */
const FIELDS = [
  { name: 'start', text: 'Start, seconds', min: 0, max: 1e5, step: 'any' },
  { name: 'maxFrames', text: 'Frames', min: 2, max: 200 },
  { name: 'step', text: 'Take every nth', min: 1, max: 100 },
  { name: 'size', text: 'Long side, pixels', min: 64, max: 1920 },
];

/** Builds the form; `onChange` gets a whole take. */
export function takeForm(onChange) {
  const inputs = FIELDS.map(({ text: _, ...field }) => h('input', { type: 'number', required: true, ...field }));
  const labels = FIELDS.map(({ text }, k) => h('label', {}, text, inputs[k]));
  const element = h('form', { class: 'take', change, submit: (event) => event.preventDefault() }, ...labels);

  function change() {
    if (element.reportValidity())
      onChange(Object.fromEntries(inputs.map(({ name, valueAsNumber }) => [name, valueAsNumber])));
  }

  /** Shows the take of a clip; the sample has none to choose. */
  function show({ take, files }) {
    element.hidden = files.length === 0;
    for (const input of inputs) input.value = take[input.name];
  }
  return { element, show };
}
