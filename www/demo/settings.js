/** The parameters of the package as the user has set them; what differs from the defaults lies in the store. @module */

import { GROUPS } from './settings-words.js';
import { kindOf } from './source.js';

/** @typedef {number | boolean | string} Value */

/**
 * @typedef {{name: string, doc: string, kind: 'number' | 'integer' | 'boolean' | 'choice', min: number, max: number,
 *   default: Value, expert: boolean, choices?: readonly string[]}} Parameter
 */

export class Settings {
  /**
   * @param {import('./store.js').Store} store
   * @param {Parameter[]} parameters
   */
  constructor(store, parameters) {
    this.store = store;
    /** @type {Map<string, Parameter>} */
    this.parameters = new Map(parameters.map((parameter) => [parameter.name, parameter]));
  }

  /** What differs from the default. */
  get changed() {
    return this.store.state.changed;
  }

  /** @param {string} name */
  get(name) {
    return this.changed.get(name) ?? this.parameters.get(name)?.default ?? 0;
  }

  /**
   * @param {string} name
   * @param {Value} value
   * @returns {boolean} false where it is not legal; then nothing changes
   */
  set(name, value) {
    const parameter = this.parameters.get(name);
    if (!parameter || !isLegal(parameter, value)) return false;
    const changed = new Map(this.changed);
    if (value === parameter.default) changed.delete(name);
    else changed.set(name, value);
    this.store.set({ changed });
    return true;
  }

  /** @param {string} name */
  reset(name) {
    const changed = new Map(this.changed);
    if (changed.delete(name)) this.store.set({ changed });
  }

  resetAll() {
    this.store.set({ changed: new Map() });
  }
}

/**
 * @param {'clip' | 'still'} kind of source
 * @returns {(group: string) => boolean} which groups of parameters count for it
 */
export function groupsFor(kind) {
  const ids = GROUPS.filter(({ only }) => (only ?? kind) === kind).map(({ id }) => id);
  return (id) => ids.includes(id);
}

/**
 * @param {Pick<import('./store.js').State, 'changed' | 'source'>} state
 * @returns {import('./run/job.js').Options} what differs from the defaults and counts for this source
 */
export function optionsOf({ changed, source }) {
  const wanted = groupsFor(kindOf(source));
  /** @type {Record<string, Record<string, Value | undefined>>} */
  const tree = {};
  for (const name of [...changed.keys()].sort()) {
    const [group, field] = name.split('.');
    if (wanted(group)) (tree[group] ??= {})[field] = changed.get(name);
  }
  // Only legal values of known parameters come in, see `Settings.set`.
  return /** @type {import('./run/job.js').Options} */ (tree);
}

/**
 * @param {Parameter} parameter
 * @param {Value} value
 * @returns {boolean}
 */
function isLegal({ kind, min, max, choices }, value) {
  if (kind === 'boolean') return typeof value === 'boolean';
  if (kind === 'choice') return choices?.includes(String(value)) ?? false;
  return typeof value === 'number' && value >= min && value <= max && (kind === 'number' || Number.isInteger(value));
}
