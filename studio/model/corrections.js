/**
 * What a user has corrected of a run, step by step, back and forth. A correction says what is one thing and what is not.
 * The session of the run decides what that means for each superpixel. Without one, and for what is painted, the masks
 * are changed by hand in the frame at hand, and that is carried to the others as far as the picture agrees.
 * @module
 */

import { carryEdit, createImageEngine, editMasks } from './library.js';
import { PageError } from './words.js';

/** @typedef {import('./library.js').Edit} Edit */
/** @typedef {import('./library.js').MaskEditor} MaskEditor */
/** @typedef {import('./library.js').ImageEngine} ImageEngine */
/** @typedef {import('./library.js').Session} Session */
/** @typedef {import('./points.js').Result} Result */
/** @typedef {import('./library.js').VideoResult} VideoResult */

/**
 * @typedef {{t: number, points: number[], radius: number}} Stroke In frame t, x0, y0, x1, y1, … and half the width, in
 *   clip pixels.
 */

/**
 * `frames` that change, null for all; `what` is done, for another result of the clip, and what `was` before.
 *
 * @typedef {{do: () => unknown, undo: () => unknown, frames: number[] | null, what: What, was?: Was}} Step
 */

/** Masks with so many of the edits. @typedef {{masks: import('./library.js').MaskSource, edits: number}} Was */

/**
 * What a step does: what is asked of the result, with the object or the strokes that are meant; or edits by hand.
 *
 * @typedef {{ask: 'join', into: number, others: number[]}
 *   | {ask: 'split', label: number, at?: {t: number, x: number, y: number}}
 *   | {ask: 'apart' | 'together', strokes: Stroke[]}
 *   | {ask: 'edits', edits: Edit[]}} What
 */

/**
 * What the corrections are of: `result` is the run's own as it is now, and takes what a correction makes of it.
 *
 * @typedef {Pick<import('./clip-job.js').ClipJob, 'images' | 'cuts' | 'result' | 'session'>} Corrected
 */

export class Corrections {
  /** @param {Corrected} of */
  constructor(of) {
    this.of = of;
    /** @type {Step[]} */
    this.done = [];
    /** @type {Step[]} */
    this.undone = [];
    /** How many come from the run before and are one step with this one. */
    this.carried = 0;
    /** @type {MaskEditor | null} */
    this.editor = null;
    /** @type {Promise<ImageEngine> | null} */
    this.engine = null;
  }

  /** How many can be undone. */
  count() {
    return this.done.length - this.carried;
  }

  redoable() {
    return this.undone.length;
  }

  /** Whether masks were changed by hand. */
  get byHand() {
    return (this.editor?.undoable ?? 0) > 0;
  }

  /** Whether masks were changed otherwise. */
  get changesResult() {
    return this.done.some(({ what }) => what.ask !== 'edits');
  }

  /** The masks with all corrections; null as long as there are none. */
  get masks() {
    return this.byHand ? this.editor : this.of.result;
  }

  /** @param {Step} step */
  async step(step) {
    const was = this.now;
    await step.do();
    this.done.push({ ...step, was });
    this.undone = [];
    return step.frames;
  }

  /** @returns {Was | undefined} */
  get now() {
    const { result } = this.of;
    if (!result) return undefined;
    const masks = 'masks' in result && result.masks ? compact(result, result.masks) : result;
    return { masks, edits: this.editor?.undoable ?? 0 };
  }

  /** @returns {Promise<number[] | null>} the frames that changed, null for all */
  async undo() {
    const step = this.count() > 0 && this.done.pop();
    if (!step) return [];
    await step.undo();
    this.undone.push(step);
    return step.frames;
  }

  /** @returns {Promise<number[] | null>} */
  async redo() {
    const step = this.undone.pop();
    if (!step) return [];
    await step.do();
    this.done.push(step);
    return step.frames;
  }

  /**
   * What the session decides.
   *
   * @param {Session} session
   * @param {What} what
   * @param {(session: Session) => Promise<import('./library.js').Result>} correct
   */
  asked(session, what, correct) {
    return this.step({
      what,
      do: async () => void (this.of.result = await correct(session)),
      undo: async () => void (this.of.result = await session.undo()),
      frames: null,
    });
  }

  /** Whether objects are split at a place alone. */
  get splitsAtPlace() {
    return this.of.session === null;
  }

  /**
   * Objects become part of `into`, in one step.
   *
   * @param {number} into
   * @param {number[]} others
   */
  join(into, others) {
    const { session, result } = this.of;
    const map = Object.fromEntries(others.map((one) => [one, into]));
    const what = /** @type {const} */ ({ ask: 'join', into, others });
    // Of what was painted the session knows nothing.
    if (this.byHand) return this.edited((editor) => editor.relabel(map), null);
    if (session) {
      let joined = 0;
      const undo = async () => {
        for (; joined > 0; joined -= 1) this.of.result = await session.undo();
      };
      const all = async () => {
        for (; joined < others.length; joined += 1) this.of.result = await session.merge(into, others[joined]);
      };
      // What is refused on the way leaves nothing half done.
      const act = () => all().catch((error) => undo().then(() => Promise.reject(error)));
      return this.step({ what, do: act, undo, frames: null });
    }
    // The trajectories too take the other label.
    const before = /** @type {VideoResult} */ (result);
    return this.step({
      what,
      do: () => (this.of.result = before.relabel(map)),
      undo: () => (this.of.result = before),
      frames: null,
    });
  }

  /**
   * Paints in one frame. @param {Parameters<MaskEditor['paint']>[0]} painted
   *
   * @returns {Promise<{edit: Edit, frames: number[]}>} for `carry`; `frames` grows with it
   */
  async paint(painted) {
    /** @type {Edit | undefined} */
    let edit;
    const frames = [painted.stroke?.t ?? painted.t ?? 0];
    await this.edited((editor) => (edit = editor.paint(painted)), frames);
    return { edit: /** @type {Edit} */ (edit), frames };
  }

  /**
   * Carries what was painted to other frames.
   *
   * @param {{edit: Edit, frames: number[]}} painted
   * @param {AbortSignal} signal
   * @param {(t: number) => void} onFrame
   */
  async carry({ edit, frames }, signal, onFrame) {
    this.engine ??= createImageEngine();
    await carryEdit(this.opened, edit, {
      engine: await this.engine,
      picture: (t) => this.pixels(t),
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

  /**
   * One step of one edit by hand or of several.
   *
   * @param {(editor: MaskEditor) => Edit | Edit[]} edit the first time
   * @param {number[] | null} frames
   */
  edited(edit, frames) {
    const editor = this.opened;
    /** @type {Edit[]} */
    const edits = [];
    return this.step({
      what: { ask: 'edits', edits },
      do: () => {
        if (edits.length === 0) edits.push(...[edit(editor)].flat());
        else edits.forEach(() => editor.redo());
      },
      undo: () => edits.forEach(() => editor.undo()),
      frames,
    });
  }

  /** @returns {MaskEditor} over the masks as they are at any time */
  get opened() {
    const masks = this.of.result;
    if (!masks) throw new PageError('unfinished');
    const { width, height, numFrames } = masks;
    const starts = [0, ...this.of.cuts];
    const shots = starts.map((first, k) => ({ first, last: (starts[k + 1] ?? numFrames) - 1 }));
    const live = (/** @type {number} */ t) => /** @type {typeof masks} */ (this.of.result).labels(t);
    this.editor ??= editMasks({ width, height, numFrames, shots, labels: live });
    return this.editor;
  }

  /**
   * The result with what was done by hand.
   *
   * @param {Result} result
   * @returns {Result}
   */
  over(result) {
    const { editor, byHand, highest } = this;
    if (!editor || !byHand) return result;
    const { objects } = result;
    return {
      ...result,
      objects: highest > 0 ? [...objects, { label: highest }] : objects,
      labels: (t) => editor.labels(t),
    };
  }

  /** The highest label that was painted. */
  get highest() {
    const labels = (this.editor?.edits ?? []).map((edit) => ('label' in edit ? edit.label : 0));
    return Math.max(0, ...labels);
  }

  /**
   * @param {number} t
   * @returns {Promise<ImageData>} at the size of the masks
   */
  pixels(t) {
    return this.of.images.pixels(t, this.opened);
  }

  /**
   * Edits of an earlier visit, which can be undone like those of this one.
   *
   * @param {import('./library.js').SavedEdits} saved
   */
  adopt(saved) {
    const editor = this.opened;
    editor.restore(saved);
    const masks = /** @type {import('./library.js').MaskSource} */ (this.of.result);
    this.done = editor.edits.map((edit, edits) => ({
      was: { masks, edits },
      what: { ask: 'edits', edits: [edit] },
      do: () => editor.redo(),
      undo: () => editor.undo(),
      frames: edit.parts ? [...edit.parts.keys()] : null,
    }));
  }

  close() {
    this.engine?.then(
      (engine) => engine.close(),
      () => {},
    );
    this.engine = null;
  }

  /**
   * An object is parted; by hand, the piece at a place becomes an object of its own.
   *
   * @param {number} label
   * @param {{t: number, x: number, y: number}} [at]
   */
  async split(label, at) {
    return (await byRegion()).split(this, label, at);
  }

  /**
   * Each stroke is a thing of its own; by hand, all but the first become objects.
   *
   * @param {Stroke[]} strokes
   */
  async apart(strokes) {
    return (await byRegion()).apart(this, strokes);
  }

  /**
   * The objects that strokes lie on become one.
   *
   * @param {Stroke[]} strokes
   */
  async together(strokes) {
    return (await byRegion()).together(this, strokes);
  }

  /**
   * What may be meant by a click, the smallest first.
   *
   * @param {number} t
   * @param {{x: number, y: number}} place in pixels of the masks
   */
  async grown(t, place) {
    return (await byRegion()).grown(this, t, place);
  }
}

/** Fetched when it is first asked for. */
function byRegion() {
  return import('./by-region.js');
}

/**
 * The masks of a session's result, which are large, as runs of equal labels: each correction keeps those before it.
 *
 * @param {{width: number, height: number, numFrames: number}} size
 * @param {Uint8Array} masks of all frames
 * @returns {import('./library.js').MaskSource}
 */
function compact({ width, height, numFrames }, masks) {
  const size = width * height;
  const frames = Array.from({ length: numFrames }, (_, t) => {
    const end = (t + 1) * size;
    /** @type {number[]} */
    const runs = [];
    for (let from = t * size, to = from; from < end; from = to) {
      while (to < end && masks[to] === masks[from]) to++;
      runs.push(to - t * size, masks[from]);
    }
    return Uint32Array.from(runs);
  });
  const labels = (/** @type {number} */ t) => {
    const found = new Uint8Array(size);
    for (let k = 0, from = 0; k < frames[t].length; from = frames[t][k], k += 2)
      found.fill(frames[t][k + 1], from, frames[t][k]);
    return found;
  };
  return { width, height, numFrames, labels };
}
