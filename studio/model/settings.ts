// The parameters of the package that an editor cares for, and what the user has set; what differs from the defaults lies
// in the store. A link, or a button, may set others too; the lab has all of them.

import { type Source, kindOf } from './source.js';
import type { SessionOptions } from './library.js';
import type { State, Store } from './store.js';

/** Groups of parameters that still images have. */
const STILL_GROUPS = ['contour', 'superpixel', 'still'];

/** Without masks there is nothing to edit. */
const DENSE = 'clip.dense';

/**
 * A parameter that matters first, in plain words. Its slider covers the range that is worth trying, not all that is
 * legal.
 */
export interface Essential {
  name: string;
  label: string;
  about: string;
  range: [min: number, max: number, step: number];
  unit?: string;
  only: 'clip' | 'still';
}

export const ESSENTIALS: Essential[] = [
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

type Value = number | boolean | string;

type Parameter = {
  name: string;
  doc: string;
  kind: 'number' | 'integer' | 'boolean' | 'choice';
  min: number;
  max: number;
  default: Value;
  expert: boolean;
  choices?: readonly string[];
};

export class Settings {
  parameters: Map<string, Parameter>;

  constructor(
    readonly store: Store,
    parameters: Parameter[],
  ) {
    this.parameters = new Map(
      parameters.filter(({ name }) => name !== DENSE).map((parameter) => [parameter.name, parameter]),
    );
  }

  /** What differs from the default. */
  get changed() {
    return this.store.state.changed;
  }

  get(name: string) {
    return this.changed.get(name) ?? this.parameters.get(name)?.default ?? 0;
  }

  /** Returns false where it is not legal; then nothing changes. */
  set(name: string, value: Value): boolean {
    const parameter = this.parameters.get(name);
    if (!parameter || !isLegal(parameter, value)) return false;
    const changed = new Map(this.changed);
    if (value === parameter.default) changed.delete(name);
    else changed.set(name, value);
    this.store.set({ changed });
    return true;
  }

  reset(name: string) {
    const changed = new Map(this.changed);
    if (changed.delete(name)) this.store.set({ changed });
  }

  resetAll() {
    this.store.set({ changed: new Map() });
  }
}

export function counts(source: Source | null, name: string): boolean {
  const [group] = name.split('.');
  return kindOf(source) === 'still' ? STILL_GROUPS.includes(group) : group !== 'still';
}

/** Returns what differs from the defaults and counts for this source. */
export function optionsOf({ changed, source }: Pick<State, 'changed' | 'source'>): SessionOptions {
  const tree: Record<string, Record<string, Value | undefined>> = {};
  for (const name of [...changed.keys()].filter((one) => counts(source, one)).sort()) {
    const [group, field] = name.split('.');
    (tree[group] ??= {})[field] = changed.get(name);
  }
  // Only legal values of known parameters come in, see `Settings.set`.
  return tree;
}

function isLegal({ kind, min, max, choices }: Parameter, value: Value): boolean {
  if (kind === 'boolean') return typeof value === 'boolean';
  if (kind === 'choice') return choices?.includes(String(value)) ?? false;
  return typeof value === 'number' && value >= min && value <= max && (kind === 'number' || Number.isInteger(value));
}
