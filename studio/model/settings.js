/**
 * The parameters of the package that an editor cares for, and what the user has set; what differs from the defaults lies
 * in the store. A link, or a button, may set others too; the lab has all of them.
 * @module
 */

import { kindOf } from './source.js';

/** Groups of parameters that still images have. */
const STILL_GROUPS = ['contour', 'superpixel', 'still'];

/** Without masks there is nothing to edit. */
const DENSE = 'clip.dense';

/**
 * A parameter that matters first, in plain words. Its slider covers the range that is worth trying, not all that is
 * legal.
 *
 * @typedef {object} Essential
 * @property {string} name
 * @property {string} label
 * @property {string} about
 * @property {[min: number, max: number, step: number]} range
 * @property {string} [unit]
 * @property {'clip' | 'still'} only
 */

/** @type {Essential[]} */
export const ESSENTIALS = [
  {
    name: 'discretize.mergeLogOdds',
    label: 'Keeping apart',
    about: 'Higher keeps parts that move differently apart; lower makes fewer, larger objects.',
    range: [1, 5, 0.1],
    only: 'clip',
  },
  {
    name: 'affinity.noiseFloor',
    label: 'Shaking to ignore',
    about: 'Lower notices slower motion; higher takes more of it for shaking.',
    range: [0.05, 1, 0.05],
    unit: 'px a frame',
    only: 'clip',
  },
  {
    name: 'trajectory.gridStep',
    label: 'Distance of points',
    about: 'Lower finds smaller objects and takes longer.',
    range: [4, 20, 1],
    unit: 'px',
    only: 'clip',
  },
  {
    name: 'cut.spatialWeight',
    label: 'Smoothness of masks',
    about: 'Higher gives rounder masks that lose thin parts.',
    range: [0, 8, 0.5],
    only: 'clip',
  },
  {
    name: 'superpixel.mergeThreshold',
    label: 'Joining',
    about: 'Higher makes fewer, larger superpixels.',
    range: [0, 10, 0.5],
    only: 'still',
  },
  {
    name: 'still.weight',
    label: 'Weight of the embedding',
    about: 'How much its discontinuities count beside the boundaries.',
    range: [0, 4, 0.1],
    only: 'still',
  },
];

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
    this.parameters = new Map(
      parameters.filter(({ name }) => name !== DENSE).map((parameter) => [parameter.name, parameter]),
    );
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
 * @param {import('./source.js').Source | null} source
 * @param {string} name of a parameter
 * @returns {boolean} whether it counts for that
 */
export function counts(source, name) {
  const [group] = name.split('.');
  return kindOf(source) === 'still' ? STILL_GROUPS.includes(group) : group !== 'still';
}

/**
 * @param {Pick<import('./store.js').State, 'changed' | 'source'>} state
 * @returns {import('./job.js').Options} what differs from the defaults and counts for this source
 */
export function optionsOf({ changed, source }) {
  /** @type {Record<string, Record<string, Value | undefined>>} */
  const tree = {};
  for (const name of [...changed.keys()].filter((one) => counts(source, one)).sort()) {
    const [group, field] = name.split('.');
    (tree[group] ??= {})[field] = changed.get(name);
  }
  // Only legal values of known parameters come in, see `Settings.set`.
  return /** @type {import('./job.js').Options} */ (tree);
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
