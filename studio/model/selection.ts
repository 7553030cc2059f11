// Visibility and selection of objects.

import type { ObjectFacts } from './presence.js';
import type { Store } from './store.js';

/** Returns the facts of the background and of objects that appear. */
export function listObjects(facts: readonly ObjectFacts[]): ObjectFacts[] {
  return facts.filter(({ object, first }) => object === 0 || first >= 0);
}

/** Returns one more than the highest label. */
function countObjects(facts: readonly ObjectFacts[]): number {
  return listObjects(facts).reduce((most, { object }) => Math.max(most, object + 1), 0);
}

/** Returns the hidden objects that still exist. */
export function keepHidden(hidden: ReadonlySet<number>, facts: readonly ObjectFacts[]): ReadonlySet<number> {
  const count = countObjects(facts);
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

  /** Shows only this object, or all if it is the only one shown. */
  isolate(object: number) {
    const hidden = Array.from({ length: this.count }, (_, k) => k).filter((k) => k !== object);
    this.store.set({ hidden: new Set(this.isAlone(object) ? [] : hidden) });
  }

  isAlone(object: number) {
    return this.count > 1 && this.has(object) && this.store.state.hidden.size === this.count - 1;
  }

  /** The objects that are shown, and the number of all. */
  get objects(): { kept: number[]; all: number } {
    const objects = listObjects(this.store.state.analysis?.facts ?? []).flatMap(({ object }) =>
      object > 0 ? [object] : [],
    );
    return { kept: objects.filter((object) => this.has(object)), all: objects.length };
  }

  /** Adds an object to the selection, or removes it. An object that is shown alone is selected with the first one. */
  toggleSelected(object: number) {
    const { phase, analysis, job } = this.store.state;
    if (object < 1 || phase !== 'done' || !analysis?.segmentation || !job?.corrector) return;
    const selected = new Set(this.store.state.selected);
    const alone = this.objects.kept.find((kept) => kept !== object && this.isAlone(kept));
    if (selected.size === 0 && alone !== undefined) selected.add(alone);
    if (!selected.delete(object)) selected.add(object);
    this.store.set({ selected });
  }

  /**
   * Joins objects. The joined object is kept if one of them was.
   * @returns the changed frames; null for all
   */
  async join(into: number, others: number[]): Promise<number[] | null> {
    const { job } = this.store.state;
    const frames = (await job?.corrector?.join(into, others)) ?? null;
    const parts = [into, ...others];
    if (into > 0 && job === this.store.state.job && parts.some((part) => this.has(part)))
      this.store.set({ hidden: new Set([...this.store.state.hidden].filter((object) => !parts.includes(object))) });
    return frames;
  }

  isSelected(object: number) {
    return this.store.state.selected.has(object);
  }

  get count() {
    return countObjects(this.store.state.analysis?.facts ?? []);
  }
}
