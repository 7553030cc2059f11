/** The parameters of the package as the user has set them. @module */

/** @typedef {{name: string, doc: string, kind: 'number' | 'integer' | 'boolean' | 'choice', min: number, max: number, default: number | boolean | string, choices?: readonly string[]}} Parameter */

/** Fires `change` whenever a value does; the event's `detail` is the parameter's name. */
export class Settings extends EventTarget {
  /** @param {Parameter[]} parameters */
  constructor(parameters) {
    super();
    /** @type {Map<string, Parameter>} */
    this.parameters = new Map(parameters.map((parameter) => [parameter.name, parameter]));
    /** @type {Map<string, number | boolean | string>} What differs from the default. */
    this.changed = new Map();
  }

  /** @param {string} name */
  get(name) {
    return this.changed.get(name) ?? this.parameters.get(name)?.default ?? 0;
  }

  /**
   * @param {string} name
   * @param {number | boolean | string} value
   * @returns {boolean} false where it is not legal; then nothing changes
   */
  set(name, value) {
    const parameter = this.parameters.get(name);
    if (!parameter || !isLegal(parameter, value)) return false;
    if (value === parameter.default) this.changed.delete(name);
    else this.changed.set(name, value);
    this.tell(name);
    return true;
  }

  /** @param {string} name */
  reset(name) {
    if (this.changed.delete(name)) this.tell(name);
  }

  resetAll() {
    for (const name of [...this.changed.keys()]) this.reset(name);
  }

  /**
   * @param {(group: string) => boolean} [wanted] which groups of the parameter tree; all if not said
   * @returns {Record<string, Record<string, number | boolean | string>>} what differs from the defaults, as options of the package
   */
  tree(wanted = () => true) {
    /** @type {Record<string, Record<string, number | boolean | string>>} */
    const tree = {};
    for (const name of [...this.changed.keys()].sort()) {
      const [group, field] = name.split('.');
      if (wanted(group)) (tree[group] ??= {})[field] = this.get(name);
    }
    return tree;
  }

  /** @param {string} name */
  tell(name) {
    this.dispatchEvent(new CustomEvent('change', { detail: name }));
  }
}

/**
 * @param {Parameter} parameter
 * @param {number | boolean | string} value
 * @returns {boolean}
 */
function isLegal({ kind, min, max, choices }, value) {
  if (kind === 'boolean') return typeof value === 'boolean';
  if (kind === 'choice') return choices?.includes(String(value)) ?? false;
  return typeof value === 'number' && value >= min && value <= max && (kind === 'number' || Number.isInteger(value));
}
