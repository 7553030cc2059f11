// Visibility and selection of objects.

import type { Corrections, Stroke } from './corrections.js';
import type { Edit } from './library.js';
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

/** The objects of a join, which of them were hidden before, and whether the joined object is kept. */
type Join = { parts: number[]; hidden: number[]; isKept: boolean };

export class Selection {
  joins = new WeakMap<Edit, Join>();

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
    if (object < 1 || phase !== 'done' || !analysis || !job?.corrector) return;
    const selected = new Set(this.store.state.selected);
    const onlyKept = this.objects.kept.find((id) => id !== object && this.isAlone(id));
    if (selected.size === 0 && onlyKept !== undefined) selected.add(onlyKept);
    if (!selected.delete(object)) selected.add(object);
    this.store.set({ selected });
  }

  /**
   * Joins objects. The joined object is kept if one of them was.
   * @returns the changed frames; null for all
   */
  join(into: number, others: number[]): Promise<number[] | null> {
    const parts = into > 0 ? [into, ...others] : others;
    return this.joinParts(parts, into > 0, (corrector) => corrector.join(into, others));
  }

  /**
   * Joins the objects under strokes. The joined object is kept if one of them was.
   * @returns the changed frames; null for all
   */
  async joinStrokes(strokes: Stroke[]): Promise<number[] | null> {
    const parts = (await this.corrector?.objectsUnder(strokes)) ?? [];
    return this.joinParts(parts, true, (corrector) => corrector.joinStrokes(strokes));
  }

  /** @param isObject false if they become background */
  async joinParts(
    parts: number[],
    isObject: boolean,
    apply: (corrector: Corrections) => Promise<number[] | null>,
  ): Promise<number[] | null> {
    const { corrector } = this;
    if (!corrector) return [];
    const hidden = parts.filter((part) => !this.has(part));
    const join = { parts, hidden, isKept: isObject && hidden.length < parts.length };
    const frames = await apply(corrector);
    const edit = corrector.edits.at(-1);
    if (edit) this.joins.set(edit, join);
    if (join.isKept && corrector === this.corrector) this.hideParts(parts, []);
    return frames;
  }

  /**
   * Undoes the last correction. Undoing a join hides the objects that were hidden before it.
   * @returns the changed frames; null for all
   */
  async undo(): Promise<number[] | null> {
    const { corrector } = this;
    const edit = corrector?.edits.at(-1);
    const frames = (await corrector?.undo()) ?? null;
    const join = edit && this.joins.get(edit);
    if (join && corrector === this.corrector && corrector?.edits.at(-1) !== edit)
      this.hideParts(join.parts, join.hidden);
    return frames;
  }

  /** Applies the last undone correction again. */
  async redo(): Promise<number[] | null> {
    const { corrector } = this;
    const frames = (await corrector?.redo()) ?? null;
    const edit = corrector?.edits.at(-1);
    const join = edit && this.joins.get(edit);
    if (join?.isKept && corrector === this.corrector) this.hideParts(join.parts, []);
    return frames;
  }

  /** Hides some objects of a join, and shows its others. */
  hideParts(parts: number[], hidden: number[]) {
    const otherHidden = [...this.store.state.hidden].filter((object) => !parts.includes(object));
    this.store.set({ hidden: new Set([...otherHidden, ...hidden]) });
  }

  get corrector(): Corrections | null {
    return this.store.state.job?.corrector ?? null;
  }

  isSelected(object: number) {
    return this.store.state.selected.has(object);
  }

  get count() {
    return countObjects(this.store.state.analysis?.facts ?? []);
  }
}
