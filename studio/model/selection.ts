// Which objects are shown.

import type { Facts } from './presence.js';
import type { Store } from './store.js';

/** Returns the facts of the background and of the objects that are there at all. */
export function listed(facts: readonly Facts[]): Facts[] {
  return facts.filter(({ object, first }) => object === 0 || first >= 0);
}

/** Returns one more than the highest number among those listed. */
function countOf(facts: readonly Facts[]): number {
  return listed(facts).reduce((most, { object }) => Math.max(most, object + 1), 0);
}

/** @returns what is hidden stays hidden, if it is there */
export function hiddenAmong(hidden: ReadonlySet<number>, facts: readonly Facts[]): ReadonlySet<number> {
  const count = countOf(facts);
  return new Set([...hidden].filter((object) => object < count));
}

export class Selection {
  constructor(readonly store: Store) {}

  reset() {
    this.store.set({ hidden: new Set() });
  }

  has(object: number) {
    return !this.store.state.hidden.has(object);
  }

  toggle(object: number) {
    const hidden = new Set(this.store.state.hidden);
    if (!hidden.delete(object)) hidden.add(object);
    this.store.set({ hidden });
  }

  /** Shows this object alone, or all again when it already is alone. */
  isolate(object: number) {
    const others = Array.from({ length: this.count }, (_, k) => k).filter((k) => k !== object);
    this.store.set({ hidden: new Set(this.isAlone(object) ? [] : others) });
  }

  isAlone(object: number) {
    return this.count > 1 && this.has(object) && this.store.state.hidden.size === this.count - 1;
  }

  /** Returns the objects that are kept, and how many there are. */
  get objects(): { kept: number[]; all: number } {
    const objects = listed(this.store.state.found?.facts ?? []).flatMap(({ object }) => (object > 0 ? [object] : []));
    return { kept: objects.filter((object) => this.has(object)), all: objects.length };
  }

  /** Chooses an object with others, to be joined with them; or leaves it out again. */
  choose(object: number) {
    const { phase, found, job } = this.store.state;
    if (object < 1 || phase !== 'done' || !found?.points || !job?.corrector) return;
    const chosen = new Set(this.store.state.chosen);
    if (!chosen.delete(object)) chosen.add(object);
    this.store.set({ chosen });
  }

  isChosen(object: number) {
    return this.store.state.chosen.has(object);
  }

  get count() {
    return countOf(this.store.state.found?.facts ?? []);
  }
}
