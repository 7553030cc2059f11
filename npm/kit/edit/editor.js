// Masks changed by hand: painted, erased, given other labels; undone and done again. The masks below stay as they are.

import { TraceCutError, illegal, isPlainObject, wholeNumber } from '../../check/errors.js';
import { MAX_LABEL, checkMasks, labelsOf } from '../../check/masks.js';
import { checkedRegion, strokeRegion } from './regions.js';

/** @typedef {import('../../check/masks.js').MaskSource} MaskSource */
/** @typedef {import('./regions.js').Region} Region */

/**
 * What an edit does in one frame; `evidence` says how sure it is to be meant there, 0 to 1: 1 where it was painted.
 * @typedef {{region: Region, evidence: number}} Part
 */

/**
 * One step that can be undone: pixels of some frames get a label (0 erases), either all pixels or those that have one of
 * the labels `over`; or labels get others in all frames.
 * @typedef {{label: number, over: readonly number[] | null, parts: Map<number, Part>, table?: undefined}
 *   | {table: Readonly<Record<number, number>>, parts?: undefined}} Edit
 */

/**
 * Edits in a form for JSON.
 * @typedef {{width: number, height: number, numFrames: number, edits: object[]}} SavedEdits
 */

/**
 * Masks with edits over them: wherever masks are taken, an editor may stand. Regions are kept as runs; the masks
 * themselves are made when they are asked for.
 */
export class MaskEditor {
  #masks;
  /** @type {Edit[]} */
  #done = [];
  /** @type {Edit[]} What was undone, the last first to be done again. */
  #undone = [];
  /** @type {Set<number> | undefined} The labels of the masks below. */
  #below;

  /** @param {MaskSource} masks */
  constructor(masks) {
    checkMasks(masks);
    this.#masks = masks;
    /** Width of the masks in pixels. */
    this.width = masks.width;
    /** Height of the masks in pixels. */
    this.height = masks.height;
    /** Number of frames. */
    this.numFrames = masks.numFrames;
    /** Stretches of frames without a cut, where they are known. */
    this.shots = masks.shots;
    /** The time of each frame in seconds, where known. */
    this.times = masks.times ?? null;
    /** When the last frame ends, in seconds, where known. */
    this.end = masks.end ?? null;
  }

  /** The edits in force, first to last. @returns {readonly Edit[]} */
  get edits() {
    return this.#done;
  }

  /** How many edits can be undone. */
  get undoable() {
    return this.#done.length;
  }

  /** How many can be done again. */
  get redoable() {
    return this.#undone.length;
  }

  /**
   * The mask of frame `t` with all edits, a copy.
   * @param {number} t
   * @returns {Uint8Array<ArrayBuffer>}
   */
  labels(t) {
    const labels = Uint8Array.from(labelsOf(this.#masks, t));
    for (const edit of this.#done) apply(edit, t, labels);
    return labels;
  }

  /**
   * A label that nothing has in any frame.
   * @returns {number} 1 to 255
   */
  newLabel() {
    const used = new Set(this.#used());
    for (let label = 1; label <= MAX_LABEL; label += 1) if (!used.has(label)) return label;
    throw new TraceCutError('state', `all ${MAX_LABEL} labels are in use; merge or erase objects first`);
  }

  /**
   * Gives pixels of one frame a label.
   * @param {object} painted
   * @param {number} painted.label 1 to 255; 0 erases
   * @param {import('./regions.js').BrushStroke} [painted.stroke] what a brush covers
   * @param {number} [painted.t] or the pixels of this frame
   * @param {Region} [painted.region] that are meant
   * @param {readonly number[]} [painted.over] only pixels that have one of these labels; all where it is left out
   * @returns {Edit} to be carried to other frames
   */
  paint(painted) {
    if (!isPlainObject(painted)) throw illegal('param', 'painted', painted, 'an object {label, stroke}');
    const { label, stroke, over = null } = painted;
    const t = wholeNumber('param', stroke ? 'stroke.t' : 't', stroke ? stroke.t : painted.t, 0, this.numFrames - 1);
    const region = stroke
      ? strokeRegion(stroke, this.width, this.height)
      : checkedRegion(painted.region, this.width * this.height);
    wholeNumber('param', 'label', label, 0, MAX_LABEL);
    over?.forEach((one, k) => wholeNumber('param', `over[${k}]`, one, 0, MAX_LABEL));
    return this.#do({ label, over, parts: new Map([[t, { region, evidence: 1 }]]) });
  }

  /**
   * Adds another frame to an edit that is in force: part of the same step, undone with it.
   * @param {Edit} edit as `paint` gave it
   * @param {number} t
   * @param {Region} region
   * @param {number} evidence 0 to 1
   */
  extend(edit, t, region, evidence) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    checkedRegion(region, this.width * this.height);
    if (!edit.parts || !this.#done.includes(edit))
      throw new TraceCutError('state', 'only a painted edit that is in force can go on in other frames');
    edit.parts.set(t, { region, evidence });
  }

  /**
   * Gives objects other labels in all frames: `{3: 1}` makes 3 part of 1, `{3: 0}` makes it background.
   * @param {Record<number, number>} map
   * @returns {Edit}
   */
  relabel(map) {
    if (!isPlainObject(map)) throw illegal('param', 'map', map, 'an object such as {3: 1}');
    for (const [from, to] of Object.entries(map)) {
      wholeNumber('param', 'a label of map', Number(from), 0, MAX_LABEL);
      wholeNumber('param', `map[${from}]`, to, 0, MAX_LABEL);
    }
    return this.#do({ table: { ...map } });
  }

  /** Takes the last edit back. @returns {Edit | null} null where there was none */
  undo() {
    const edit = this.#done.pop();
    if (!edit) return null;
    this.#undone.push(edit);
    return edit;
  }

  /** Does again what was undone last. @returns {Edit | null} null where there was nothing */
  redo() {
    const edit = this.#undone.pop();
    if (!edit) return null;
    this.#done.push(edit);
    return edit;
  }

  /** The edits in force, for `restore`. @returns {SavedEdits} */
  toJSON() {
    const edits = this.#done.map(({ ...edit }) => ({
      ...edit,
      ...(edit.parts && {
        parts: [...edit.parts].map(([t, { region, evidence }]) => ({ t, region: [...region], evidence })),
      }),
    }));
    return { width: this.width, height: this.height, numFrames: this.numFrames, edits };
  }

  /**
   * Does saved edits, after those that are in force.
   * @param {SavedEdits} saved as `toJSON` gave it, of masks of this size
   */
  restore(saved) {
    const { width, height, numFrames } = this;
    const size = isPlainObject(saved) ? `${saved.width} × ${saved.height} × ${saved.numFrames}` : 'nothing';
    if (size !== `${width} × ${height} × ${numFrames}`)
      throw new TraceCutError('data', `these edits are of ${size} (expected ${width} × ${height} × ${numFrames})`);
    // Checked as a whole before anything is done: nothing is half restored.
    const trial = new MaskEditor(this.#masks);
    for (const edit of /** @type {any[]} */ (saved.edits)) {
      if (edit.table) {
        trial.relabel(edit.table);
        continue;
      }
      const parts = edit.parts.map((/** @type {any} */ part) => ({ ...part, region: Uint32Array.from(part.region) }));
      const [first, ...others] = parts;
      const made = trial.paint({ label: edit.label, over: edit.over ?? undefined, t: first.t, region: first.region });
      for (const { t, region, evidence } of others) trial.extend(made, t, region, evidence);
    }
    this.#done.push(...trial.#done);
    this.#undone = [];
  }

  /** @param {Edit} edit */
  #do(edit) {
    this.#done.push(edit);
    this.#undone = [];
    return edit;
  }

  *#used() {
    this.#below ??= new Set(this.#labelsBelow());
    yield* this.#below;
    for (const edit of this.#done) {
      if (edit.table) yield* Object.values(edit.table);
      else yield edit.label;
    }
  }

  *#labelsBelow() {
    for (let t = 0; t < this.numFrames; t += 1) yield* new Set(labelsOf(this.#masks, t));
  }
}

/**
 * @param {Edit} edit
 * @param {number} t
 * @param {Uint8Array} labels
 */
function apply(edit, t, labels) {
  if (edit.table) {
    const { table } = edit;
    const all = Uint8Array.from({ length: MAX_LABEL + 1 }, (_, label) => table[label] ?? label);
    for (let p = 0; p < labels.length; p += 1) labels[p] = /** @type {number} */ (all[Number(labels[p])]);
    return;
  }
  const part = edit.parts.get(t);
  if (!part) return;
  const { region } = part;
  const over = edit.over && new Set(edit.over);
  for (let k = 0; k < region.length; k += 2) {
    const [from, length] = [Number(region[k]), Number(region[k + 1])];
    if (!over) labels.fill(edit.label, from, from + length);
    else for (let p = from; p < from + length; p += 1) if (over.has(Number(labels[p]))) labels[p] = edit.label;
  }
}

/**
 * Masks that can be painted, erased and given other labels, step by step, each of which can be undone.
 *
 * ```js
 * const editor = editMasks(result);
 * const edit = editor.paint({ label: 0, stroke: { t: 4, points: [100, 80, 120, 90], radius: 6 } });
 * await carryEdit(editor, edit, { picture: (t) => frames[t] });
 * await maskZip(editor);
 * ```
 * @param {MaskSource} masks
 * @returns {MaskEditor}
 */
export function editMasks(masks) {
  return new MaskEditor(masks);
}
