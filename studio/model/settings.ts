// The choices that the page offers, and the user's changes of parameters, which lie in the store. Links and buttons may
// set other parameters too; the lab has all of them.

import type { SessionOptions } from './library.js';
import type { State, Store } from './store.js';

/** Not offered: the page needs masks, and has no still images. */
const isOffered = (name: string) => name !== 'clip.dense' && !name.startsWith('still.');

/** A plain choice of what to do differently. Each option has a value of one parameter; null is the default. */
export interface SettingChoice {
  name: string;
  label: string;
  options: { label: string; value: number | null }[];
}

/**
 * The choices of clips. On the drawn sample at 160 × 90 the step of 6 finds the third object, which 8 does not; on a clip of a camel
 * “More” makes four objects of one; the others are chosen by eye.
 */
export const SETTING_CHOICES: SettingChoice[] = [
  {
    name: 'discretize.mergeLogOdds',
    label: 'Objects',
    options: [
      { label: 'Fewer', value: 1.5 },
      { label: 'Standard', value: null },
      { label: 'More', value: 4 },
    ],
  },
  {
    name: 'trajectory.gridStep',
    label: 'Small things',
    options: [
      { label: 'Standard', value: null },
      { label: 'Smaller, slower', value: 6 },
    ],
  },
  {
    name: 'cut.temporalWeight',
    label: 'Masks',
    options: [
      { label: 'Standard', value: null },
      { label: 'Steadier', value: 3 },
    ],
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
      parameters.filter(({ name }) => isOffered(name)).map((parameter) => [parameter.name, parameter]),
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

/** Returns the changed parameters that are no option of a choice, as text. */
export function otherChanges({ changed }: Pick<State, 'changed'>): string[] {
  const isOption = (name: string, value: Value) =>
    SETTING_CHOICES.some((choice) => choice.name === name && choice.options.some((option) => option.value === value));
  return [...changed].filter((entry) => !isOption(...entry)).map(([name, value]) => `${name} = ${value}`);
}

/** Returns the changed parameters as options of a session. */
export function sessionOptions({ changed }: Pick<State, 'changed'>): SessionOptions {
  const tree: Record<string, Record<string, Value | undefined>> = {};
  for (const name of [...changed.keys()].sort()) {
    const [group, field] = name.split('.');
    (tree[group] ??= {})[field] = changed.get(name);
  }
  // Only valid values of known parameters come in, see `Settings.set`.
  return tree;
}

/** Returns the changed parameters that give these options. */
export function changedParameters(options: SessionOptions): State['changed'] {
  const groups = Object.entries(options as Record<string, Record<string, Value>>);
  return new Map(
    groups.flatMap(([group, fields]) => Object.entries(fields).map(([field, value]) => [`${group}.${field}`, value])),
  );
}

function isLegal({ kind, min, max, choices }: Parameter, value: Value): boolean {
  if (kind === 'boolean') return typeof value === 'boolean';
  if (kind === 'choice') return choices?.includes(String(value)) ?? false;
  return typeof value === 'number' && value >= min && value <= max && (kind === 'number' || Number.isInteger(value));
}
