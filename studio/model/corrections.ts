// What a user has corrected of a run: the editor of its masks, whatever made them, and what the page needs around it.

import { createImageEngine, decodeRuns, editMasks, growRegions } from './library.js';
import { PageError } from './words.js';
import type { ClipJob } from './clip-job.js';
import type {
  Edit,
  ImageEngine,
  MaskEditor,
  MaskSource,
  Place,
  Region,
  SavedEdits,
  Stroke as PackageStroke,
} from './library.js';
import type { Result } from './points.js';

/** A stroke of the package, as it grows. */
export type Stroke = PackageStroke & { points: number[] };

/** What the corrections are of: `result` is the run's own as it is now, and takes what its session makes of it. */
type Corrected = Pick<ClipJob, 'images' | 'result' | 'session'>;

export class Corrections {
  /** How many come from the run before and are one step with this one. */
  carried = 0;
  editor: MaskEditor | null = null;
  engine: Promise<ImageEngine> | null = null;
  /** The masks before each correction of the session. */
  earlier = new WeakMap<Edit, MaskSource>();

  constructor(public of: Corrected) {}

  /** The corrections in force. */
  get edits(): readonly Edit[] {
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
   * @returns the frames that changed, null for all
   */
  async step(correct: (editor: MaskEditor) => Promise<Edit>): Promise<number[] | null> {
    const editor = this.opened;
    const before = editor.usesSession ? await editor.toResult() : null;
    const edit = await correct(editor);
    if (before && edit.corrections > 0) this.earlier.set(edit, before);
    return this.changed(edit);
  }

  changed(edit: Edit | null): number[] | null {
    this.of.result = this.opened.masks as Corrected['result'];
    return edit ? framesOf(edit) : [];
  }

  async undo() {
    return this.count() > 0 ? this.changed(await this.opened.undo()) : [];
  }

  async redo() {
    return this.changed(await this.opened.redo());
  }

  /** Objects become part of `into`, in one step. */
  join(into: number, others: number[]) {
    return this.step((editor) => editor.merge(into, others));
  }

  /**
   * Paints in one frame.
   * @returns for `carry`; `frames` grows with it
   */
  async paint(painted: Parameters<MaskEditor['paint']>[0]): Promise<{ edit: Edit; frames: number[] }> {
    const edit = await this.opened.paint(painted);
    return { edit, frames: framesOf(edit) ?? [] };
  }

  /** Carries what was painted to other frames. */
  async carry({ edit, frames }: { edit: Edit; frames: number[] }, signal: AbortSignal, onFrame: (t: number) => void) {
    await this.opened.carry(edit, {
      signal,
      onFrame: ({ t }) => {
        frames.push(t);
        onFrame(t);
      },
    });
  }

  /** Returns a label that nothing has. */
  newLabel(): number {
    return this.opened.newLabel();
  }

  get opened(): MaskEditor {
    const { result, session } = this.of;
    if (!result) throw new PageError('unfinished');
    this.editor ??= editMasks(result, {
      ...(session ? { session } : {}),
      picture: (t) => this.pixels(t),
      engine: () => this.flows(),
    });
    return this.editor;
  }

  flows(): Promise<ImageEngine> {
    this.engine ??= createImageEngine();
    return this.engine;
  }

  /** The masks that a correction was made in. */
  before(edit: Edit): MaskEditor {
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

  /** The result with what was done over its masks. */
  over(result: Result): Result {
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

  /** Returns the frame at the size of the masks. */
  pixels(t: number): Promise<ImageData> {
    const { images, result } = this.of;
    if (!result) throw new PageError('unfinished');
    return images.pixels(t, result);
  }

  /** Edits of an earlier visit, which can be undone like those of this one. */
  adopt(saved: SavedEdits) {
    this.opened.restore(saved);
  }

  /** An object is parted; by hand, the piece at a place becomes an object of its own. */
  async split(label: number, at?: Place) {
    if (!at && this.splitsAtPlace) throw new PageError('no-place');
    return this.step((editor) => editor.split(label, at));
  }

  /** Each stroke is a thing of its own. */
  apart(strokes: PackageStroke[]) {
    return this.step((editor) => editor.apart(strokes));
  }

  /** The objects that strokes lie on become one. */
  together(strokes: PackageStroke[]) {
    return this.step((editor) => editor.together(strokes));
  }

  /**
   * What may be meant by a click, the smallest first.
   * @param place in pixels of the masks
   */
  async grown(t: number, place: { x: number; y: number }): Promise<{ regions: Region[]; likeliest: number }> {
    const engine = await this.flows();
    const { numFrames, shots = [{ first: 0, last: numFrames - 1 }] } = this.opened;
    // Motion to the frame after, or the one before where that is another shot or none.
    const { first, last } = shots.find((shot) => t <= shot.last) ?? { first: 0, last: numFrames - 1 };
    const beside = t < last ? t + 1 : Math.max(first, t - 1);
    const [picture, other] = [await this.pixels(t), await this.pixels(beside)];
    const [superpixels, flow] = [await engine.superpixels(picture), await engine.flow(picture, other)];
    const found = await growRegions({ superpixels, picture, flow }, place);
    const area = (pixels: Uint8Array) => pixels.reduce((sum, inside) => sum + inside, 0);
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

/** Returns the frames that it changes, null for all. */
function framesOf({ corrections, table, paints }: Edit): number[] | null {
  if (corrections > 0 || Object.keys(table).length > 0) return null;
  return [...new Set(paints.flatMap(({ parts }) => [...parts.keys()]))];
}
