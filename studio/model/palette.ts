// Colours, shapes and names of objects: the package's, and what only the page needs.

import { objectColor } from './library.js';

export { EDGE_STYLES, objectColor, objectShape } from './library.js';

export function objectName(object: number): string {
  return object === 0 ? 'Background' : `Object ${object}`;
}

/** Colours that have a name, those of the first seven objects before all. */
const NAMED: [string, string][] = [
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

const names = new Map<number, string>();

/**
 * The name of an object's colour: the nearest that has one, with a number from the second object on that has it.
 * @param object from 1 on
 * @returns `orange`, `purple`, `green 2`
 */
export function colourName(object: number): string {
  for (let one = names.size + 1; one <= object; one++) {
    const color = objectColor(one);
    const [name] = NAMED.reduce((best, next) => (distance(next[1], color) < distance(best[1], color) ? next : best));
    const before = [...names.values()].filter((other) => other.replace(/ \d+$/, '') === name).length;
    names.set(one, before > 0 ? `${name} ${before + 1}` : name);
  }
  return names.get(object) ?? '';
}

/**
 * How far two colours are apart to the eye, about.
 * @param a `#rrggbb`
 */
function distance(a: string, b: string) {
  const [r, g, l] = [1, 3, 5].map(
    (at) => Number.parseInt(a.slice(at, at + 2), 16) - Number.parseInt(b.slice(at, at + 2), 16),
  );
  return 3 * r * r + 4 * g * g + 2 * l * l;
}
