// Colours, shapes and names of objects.

import { objectColor } from './library.js';

export { objectColor, objectShape } from './library.js';

export function objectName(object: number): string {
  return object === 0 ? 'Background' : `Object ${object}`;
}

/** Named colours, starting with the colours of the first seven objects. */
const COLOUR_NAMES: [string, string][] = [
  ['orange', '#e69f00'],
  ['light blue', '#56b4e9'],
  ['pink', '#cc79a7'],
  ['yellow', '#f0e442'],
  ['green', '#009e73'],
  ['red', '#d55e00'],
  ['blue', '#0072b2'],
  ['purple', '#7a1fa2'],
  ['violet', '#a78bfa'],
  ['magenta', '#e020e0'],
  ['dark red', '#7f1010'],
  ['brown', '#7a5230'],
  ['beige', '#e8d8b0'],
  ['olive', '#7a7a10'],
  ['lime', '#8ae820'],
  ['light green', '#90e0a0'],
  ['dark green', '#0c5020'],
  ['turquoise', '#20d0c8'],
  ['dark blue', '#101870'],
  ['rose', '#ffb0c0'],
];

const namesByObject = new Map<number, string>();

/**
 * Returns the nearest named colour, numbered if it repeats.
 * @returns `orange`, `purple`, `green 2`; `grey` for the background
 */
export function colourName(object: number): string {
  if (object === 0) return 'grey';
  for (let next = namesByObject.size + 1; next <= object; next++) {
    const color = objectColor(next);
    const [name] = COLOUR_NAMES.reduce((best, candidate) =>
      distance(candidate[1], color) < distance(best[1], color) ? candidate : best,
    );
    const repeats = [...namesByObject.values()].filter((otherName) => otherName.replace(/ \d+$/, '') === name).length;
    namesByObject.set(next, repeats > 0 ? `${name} ${repeats + 1}` : name);
  }
  return namesByObject.get(object) ?? '';
}

/**
 * Returns an approximate perceptual distance of two colours.
 * @param a `#rrggbb`
 */
function distance(a: string, b: string) {
  const [r, g, l] = [1, 3, 5].map(
    (at) => Number.parseInt(a.slice(at, at + 2), 16) - Number.parseInt(b.slice(at, at + 2), 16),
  );
  return 3 * r * r + 4 * g * g + 2 * l * l;
}
