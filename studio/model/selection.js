/** Which objects are shown. @module */

/** @typedef {import('./presence.js').Facts} Facts */

/**
 * @param {readonly Facts[]} facts
 * @returns {Facts[]} of the background and of the objects that are there at all
 */
export function listed(facts) {
  return facts.filter(({ object, first }) => object === 0 || first >= 0);
}

/**
 * @param {readonly Facts[]} facts
 * @returns {number} one more than the highest number among those listed
 */
function countOf(facts) {
  return listed(facts).reduce((most, { object }) => Math.max(most, object + 1), 0);
}

/**
 * @param {ReadonlySet<number>} hidden
 * @param {readonly Facts[]} facts of a new result
 * @returns {ReadonlySet<number>} what is hidden stays hidden, if it is there
 */
export function hiddenAmong(hidden, facts) {
  const count = countOf(facts);
  return new Set([...hidden].filter((object) => object < count));
}

export class Selection {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store;
  }

  /** Shows all. */
  reset() {
    this.store.set({ hidden: new Set() });
  }

  /** @param {number} object */
  has(object) {
    return !this.store.state.hidden.has(object);
  }

  /** @param {number} object */
  toggle(object) {
    const hidden = new Set(this.store.state.hidden);
    if (!hidden.delete(object)) hidden.add(object);
    this.store.set({ hidden });
  }

  /**
   * Shows this object alone, or all again when it already is alone.
   *
   * @param {number} object
   */
  isolate(object) {
    const others = Array.from({ length: this.count }, (_, k) => k).filter((k) => k !== object);
    this.store.set({ hidden: new Set(this.isAlone(object) ? [] : others) });
  }

  /** @param {number} object */
  isAlone(object) {
    return this.count > 1 && this.has(object) && this.store.state.hidden.size === this.count - 1;
  }

  /** @returns {{kept: number[], all: number}} the objects that are kept, and how many there are */
  get objects() {
    const objects = listed(this.store.state.found?.facts ?? []).flatMap(({ object }) => (object > 0 ? [object] : []));
    return { kept: objects.filter((object) => this.has(object)), all: objects.length };
  }

  /**
   * Chooses an object with others, to be joined with them; or leaves it out again.
   *
   * @param {number} object
   */
  choose(object) {
    const { phase, found, job } = this.store.state;
    if (object < 1 || phase !== 'done' || !found?.points || !job?.corrector) return;
    const chosen = new Set(this.store.state.chosen);
    if (!chosen.delete(object)) chosen.add(object);
    this.store.set({ chosen });
  }

  /** @param {number} object */
  isChosen(object) {
    return this.store.state.chosen.has(object);
  }

  get count() {
    return countOf(this.store.state.found?.facts ?? []);
  }
}
