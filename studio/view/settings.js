/**
 * The parameters of the package: what their groups are called, which matter first, and what the user has set them to;
 * what differs from the defaults lies in the store.
 * @module
 */

import { kindOf } from './source.js';

/**
 * @typedef {object} Group
 * @property {string} id first part of the names of its parameters
 * @property {string} title
 * @property {string} about
 * @property {'clip' | 'still'} [only] for which kind of source it counts; both if not said
 */

/** In the order of the stages. @type {Group[]} */
export const GROUPS = [
  {
    id: 'clip',
    title: 'Frames',
    about: 'How large frames are when they are looked at, and whether there are masks.',
    only: 'clip',
  },
  { id: 'shot', title: 'Cuts', about: 'When a frame begins a new shot of a long clip.', only: 'clip' },
  {
    id: 'flow',
    title: 'Optical flow',
    about: 'How the motion of every pixel to the next frame is estimated.',
    only: 'clip',
  },
  {
    id: 'trajectory',
    title: 'Trajectories',
    about: 'Which points are followed through the clip, and when they are lost.',
    only: 'clip',
  },
  { id: 'affinity', title: 'Motion affinities', about: 'How alike two trajectories move.', only: 'clip' },
  {
    id: 'embedding',
    title: 'Embedding',
    about: 'Trajectories as points that lie close where they move alike.',
    only: 'clip',
  },
  {
    id: 'discontinuity',
    title: 'Discontinuities',
    about: 'Where neighbours lie far apart in the embedding.',
    only: 'clip',
  },
  { id: 'saliency', title: 'Saliency', about: 'What stands out against the motion around it.', only: 'clip' },
  {
    id: 'connectedness',
    title: 'Connectedness',
    about: 'What the pieces of the foreground keep apart and hold together.',
    only: 'clip',
  },
  { id: 'discretize', title: 'Clusters', about: 'From the embedding to groups of trajectories.', only: 'clip' },
  { id: 'contour', title: 'Contours', about: 'Boundaries seen in a single frame.' },
  { id: 'superpixel', title: 'Superpixels', about: 'Pieces of a frame that lie between its contours.' },
  { id: 'cut', title: 'Gabriel cut', about: 'Which superpixels belong to which object.', only: 'clip' },
  {
    id: 'background',
    title: 'Background',
    about: 'What the scene behind everything tells about the objects before it.',
    only: 'clip',
  },
  { id: 'refine', title: 'Borders of masks', about: 'Moving the borders of masks to the pixel.', only: 'clip' },
  { id: 'still', title: 'Still images', about: 'The embedding of the pixels of a single image.', only: 'still' },
];

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
    name: 'discretize.caution',
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
    name: 'superpixel.joinBelow',
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

/**
 * @param {string} name `trajectory.gridStep`
 * @returns {string} `Grid step`
 */
export function labelOf(name) {
  const words = name.slice(name.indexOf('.') + 1).replace(/[A-Z]/g, (letter) => ` ${letter.toLowerCase()}`);
  return words[0].toUpperCase() + words.slice(1);
}

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
