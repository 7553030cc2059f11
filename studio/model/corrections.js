/**
 * What a user has corrected of a run: the editor of its masks, whatever made them, and what the page needs around it.
 * @module
 */

import { createImageEngine, decodeRuns, editMasks, grownRegions } from './library.js';
import { PageError } from './words.js';

/** @typedef {import('./library.js').Edit} Edit */
/** @typedef {import('./library.js').MaskEditor} MaskEditor */
/** @typedef {import('./library.js').MaskSource} MaskSource */
/** @typedef {import('./library.js').ImageEngine} ImageEngine */
/** @typedef {import('./points.js').Result} Result */
/** A stroke of the package, as it grows. @typedef {import('./library.js').Stroke & {points: number[]}} Stroke */

/**
 * What the corrections are of: `result` is the run's own as it is now, and takes what its session makes of it.
 *
 * @typedef {Pick<import('./clip-job.js').ClipJob, 'images' | 'result' | 'session'>} Corrected
 */

export class Corrections {
  /** @param {Corrected} of */
  constructor(of) {
    this.of = of;
    /** How many come from the run before and are one step with this one. */
    this.carried = 0;
    /** @type {MaskEditor | null} */
    this.editor = null;
    /** @type {Promise<ImageEngine> | null} */
    this.engine = null;
    /** @type {WeakMap<Edit, MaskSource>} The masks before each correction of the session. */
    this.earlier = new WeakMap();
  }

  /** The corrections in force. @returns {readonly Edit[]} */
  get edits() {
    return this.editor?.edits ?? [];
  }

  /** How many can be undone. */
  count() {
    return this.edits.length - this.carried;
  }

  redoable() {
    return this.editor?.redoable ?? 0;
  }

  /** Whether the session has corrected the masks below. */
  get changesResult() {
    return this.edits.some(({ corrections }) => corrections > 0);
  }

  /** The masks with all corrections; null as long as there are none. */
  get masks() {
    return this.edits.length > 0 ? this.editor : this.of.result;
  }

  /** Whether objects are split at a place alone. */
  get splitsAtPlace() {
    return this.editor ? !this.editor.usesSession : this.of.session === null;
  }

  /**
   * One step.
   *
   * @param {(editor: MaskEditor) => Promise<Edit>} correct
   * @returns {Promise<number[] | null>} the frames that changed, null for all
   */
  async step(correct) {
    const editor = this.opened;
    const before = editor.usesSession ? await editor.toResult() : null;
    const edit = await correct(editor);
    if (before && edit.corrections > 0) this.earlier.set(edit, before);
    return this.changed(edit);
  }

  /**
   * @param {Edit | null} edit that was done or undone
   * @returns {number[] | null}
   */
  changed(edit) {
    this.of.result = /** @type {Corrected['result']} */ (this.opened.masks);
    return edit ? framesOf(edit) : [];
  }

  async undo() {
    return this.count() > 0 ? this.changed(await this.opened.undo()) : [];
  }

  async redo() {
    return this.changed(await this.opened.redo());
  }

  /**
   * Objects become part of `into`, in one step.
   *
   * @param {number} into
   * @param {number[]} others
   */
  join(into, others) {
    return this.step((editor) => editor.merge(into, others));
  }

  /**
   * Paints in one frame.
   *
   * @param {Parameters<MaskEditor['paint']>[0]} painted
   * @returns {Promise<{edit: Edit, frames: number[]}>} for `carry`; `frames` grows with it
   */
  async paint(painted) {
    const edit = await this.opened.paint(painted);
    return { edit, frames: framesOf(edit) ?? [] };
  }

  /**
   * Carries what was painted to other frames.
   *
   * @param {{edit: Edit, frames: number[]}} painted
   * @param {AbortSignal} signal
   * @param {(t: number) => void} onFrame
   */
  async carry({ edit, frames }, signal, onFrame) {
    await this.opened.carry(edit, {
      signal,
      onFrame: ({ t }) => {
        frames.push(t);
        onFrame(t);
      },
    });
  }

  /** @returns {number} a label that nothing has */
  newLabel() {
    return this.opened.newLabel();
  }

  /** @returns {MaskEditor} over the masks */
  get opened() {
    const { result, session } = this.of;
    if (!result) throw new PageError('unfinished');
    this.editor ??= editMasks(result, {
      ...(session ? { session } : {}),
      picture: (t) => this.pixels(t),
      engine: () => this.flows(),
    });
    return this.editor;
  }

  /** @returns {Promise<ImageEngine>} that stays open */
  flows() {
    this.engine ??= createImageEngine();
    return this.engine;
  }

  /**
   * The masks that a correction was made in.
   *
   * @param {Edit} edit in force
   * @returns {MaskEditor}
   */
  before(edit) {
    const earlier = this.earlier.get(edit);
    if (earlier) return editMasks(earlier);
    const { editor } = this;
    if (!editor) throw new PageError('unfinished');
    const before = editMasks(editor.masks);
    const all = editor.toJSON();
    const own = this.edits.filter(({ corrections }) => corrections === 0);
    before.restore({ ...all, edits: all.edits.slice(0, own.indexOf(edit)) });
    return before;
  }

  /**
   * The result with what was done over its masks.
   *
   * @param {Result} result
   * @returns {Result}
   */
  over(result) {
    const { editor } = this;
    const paints = this.edits.filter(({ corrections }) => corrections === 0).map((edit) => edit.paints);
    if (!editor || paints.length === 0) return result;
    const highest = Math.max(0, ...paints.flat().map(({ label }) => label));
    return {
      ...result,
      trajectories: editor.trajectories ?? result.trajectories,
      objects: highest > 0 ? [...result.objects, { label: highest }] : result.objects,
      labels: (t) => editor.labels(t),
      // A session's are of clusters.
      toTracksDat: async () => (this.of.session ? result : await editor.toResult()).toTracksDat(),
    };
  }

  /**
   * @param {number} t
   * @returns {Promise<ImageData>} at the size of the masks
   */
  pixels(t) {
    const { images, result } = this.of;
    if (!result) throw new PageError('unfinished');
    return images.pixels(t, result);
  }

  /**
   * Edits of an earlier visit, which can be undone like those of this one.
   *
   * @param {import('./library.js').SavedEdits} saved
   */
  adopt(saved) {
    this.opened.restore(saved);
  }

  /**
   * An object is parted; by hand, the piece at a place becomes an object of its own.
   *
   * @param {number} label
   * @param {import('./library.js').Place} [at]
   */
  async split(label, at) {
    if (!at && this.splitsAtPlace) throw new PageError('no-place');
    return this.step((editor) => editor.split(label, at));
  }

  /**
   * Each stroke is a thing of its own.
   *
   * @param {import('./library.js').Stroke[]} strokes
   */
  apart(strokes) {
    return this.step((editor) => editor.apart(strokes));
  }

  /**
   * The objects that strokes lie on become one.
   *
   * @param {import('./library.js').Stroke[]} strokes
   */
  together(strokes) {
    return this.step((editor) => editor.together(strokes));
  }

  /**
   * What may be meant by a click, the smallest first.
   *
   * @param {number} t
   * @param {{x: number, y: number}} place in pixels of the masks
   * @returns {Promise<{regions: import('./library.js').Region[], likeliest: number}>}
   */
  async grown(t, place) {
    const engine = await this.flows();
    const { numFrames, shots = [{ first: 0, last: numFrames - 1 }] } = this.opened;
    // Motion to the frame after, or the one before where that is another shot or none.
    const { first, last } = shots.find((shot) => t <= shot.last) ?? { first: 0, last: numFrames - 1 };
    const beside = t < last ? t + 1 : Math.max(first, t - 1);
    const [picture, other] = [await this.pixels(t), await this.pixels(beside)];
    const [superpixels, flow] = [await engine.superpixels(picture), await engine.flow(picture, other)];
    const found = await grownRegions({ superpixels, picture, flow }, place);
    const area = (/** @type {Uint8Array} */ pixels) => pixels.reduce((sum, inside) => sum + inside, 0);
    const regions = [...found].sort((a, b) => area(decodeRuns(a)) - area(decodeRuns(b)));
    return { regions, likeliest: regions.indexOf(found[0]) };
  }

  close() {
    this.engine?.then(
      (engine) => engine.close(),
      () => {},
    );
    this.engine = null;
  }
}

/**
 * @param {Edit} edit
 * @returns {number[] | null} the frames that it changes, null for all
 */
function framesOf({ corrections, table, paints }) {
  if (corrections > 0 || Object.keys(table).length > 0) return null;
  return [...new Set(paints.flatMap(({ parts }) => [...parts.keys()]))];
}
