// The parameters that the page offers, and the user's changes, which lie in the store. Links and buttons may set
// other parameters too; the lab has all of them.

import { type Source, sourceKind } from './source.js';
import type { SessionOptions } from './library.js';
import type { State, Store } from './store.js';

const STILL_GROUPS = ['contour', 'superpixel', 'still'];

/** Not offered: the page needs masks. */
const DENSE = 'clip.dense';

/** A parameter with a slider. Its range is what is worth trying, not all that is valid. */
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
    label: 'Object separation',
    about: 'Higher separates parts that move differently; lower makes fewer, larger objects.',
    range: [1, 5, 0.1],
    only: 'clip',
  },
  {
    name: 'affinity.noiseFloor',
    label: 'Ignore camera shake',
    about: 'Lower detects slower motion; higher ignores more shake.',
    range: [0.05, 1, 0.05],
    unit: 'px/frame',
    only: 'clip',
  },
  {
    name: 'trajectory.gridStep',
    label: 'Point spacing',
    about: 'Lower finds smaller objects but takes longer.',
    range: [4, 20, 1],
    unit: 'px',
    only: 'clip',
  },
  {
    name: 'cut.spatialWeight',
    label: 'Mask smoothness',
    about: 'Higher gives rounder masks that lose thin parts.',
    range: [0, 8, 0.5],
    only: 'clip',
  },
  {
    name: 'superpixel.mergeThreshold',
    label: 'Superpixel size',
    about: 'Higher makes fewer, larger superpixels.',
    range: [0, 10, 0.5],
    only: 'still',
  },
  {
    name: 'still.weight',
    label: 'Embedding weight',
    about: 'How much embedding discontinuities count next to boundaries.',
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

  /** The changed parameters. */
  get changed() {
    return this.store.state.changed;
  }

  get(name: string) {
    return this.changed.get(name) ?? this.parameters.get(name)?.default ?? 0;
  }

  /** Sets a parameter; returns false if the value is invalid. */
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

export function appliesTo(source: Source | null, name: string): boolean {
  const [group] = name.split('.');
  return sourceKind(source) === 'still' ? STILL_GROUPS.includes(group) : group !== 'still';
}

/** Returns the changed parameters that apply to the source. */
export function sessionOptions({ changed, source }: Pick<State, 'changed' | 'source'>): SessionOptions {
  const tree: Record<string, Record<string, Value | undefined>> = {};
  for (const name of [...changed.keys()].filter((key) => appliesTo(source, key)).sort()) {
    const [group, field] = name.split('.');
    (tree[group] ??= {})[field] = changed.get(name);
  }
  // Only valid values of known parameters come in, see `Settings.set`.
  return tree;
}

/** Returns the changed parameters that give these options; those of other kinds of source stay. */
export function changedParameters(
  { changed, source }: Pick<State, 'changed' | 'source'>,
  options: SessionOptions,
): State['changed'] {
  const groups = Object.entries(options as Record<string, Record<string, Value>>);
  return new Map([
    ...[...changed].filter(([name]) => !appliesTo(source, name)),
    ...groups.flatMap(([group, fields]) =>
      Object.entries(fields).map(([field, value]) => [`${group}.${field}`, value] as const),
    ),
  ]);
}

function isLegal({ kind, min, max, choices }: Parameter, value: Value): boolean {
  if (kind === 'boolean') return typeof value === 'boolean';
  if (kind === 'choice') return choices?.includes(String(value)) ?? false;
  return typeof value === 'number' && value >= min && value <= max && (kind === 'number' || Number.isInteger(value));
}
