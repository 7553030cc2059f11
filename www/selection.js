// The form that selects the frames of a file and their size.

import { h } from './dom.js';

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
