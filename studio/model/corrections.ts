// What a user has corrected of a run: the editor of its masks, whatever made them, and what the page needs around it.

import { createImageEngine, decodeRuns, editMasks, grownRegions } from './library.js';
import { PageError } from './messages.js';
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
import type { Result } from './segmentation.js';

/** A stroke of the package, as it grows. */
export type Stroke = PackageStroke & { points: number[] };

/** What the corrections are of: `result` is the run's own as it is now, and takes what its session makes of it. */
type CorrectionTarget = Pick<ClipJob, 'images' | 'result' | 'session'>;

export class Corrections {
  /** How many come from the run before and are one step with this one. */
  carriedCount = 0;
  editor: MaskEditor | null = null;
  engine: Promise<ImageEngine> | null = null;
  /** The masks before each correction of the session. */
  masksBeforeEdit = new WeakMap<Edit, MaskSource>();

  constructor(public target: CorrectionTarget) {}

  /** The corrections in force. */
  get edits(): readonly Edit[] {
    return this.editor?.edits ?? [];
  }

  /** How many can be undone. */
  undoCount() {
    return this.edits.length - this.carriedCount;
  }

  redoCount() {
    return this.editor?.redoable ?? 0;
  }

  /** Whether the session has corrected the masks below. */
  get changesResult() {
    return this.edits.some(({ corrections }) => corrections > 0);
  }

  /** The masks with all corrections; null as long as there are none. */
  get masks() {
    return this.edits.length > 0 ? this.editor : this.target.result;
  }

  /** Whether objects are split at a place alone. */
  get splitsAtPlace() {
    return this.editor ? !this.editor.usesSession : this.target.session === null;
  }

  /**
   * One step.
   * @returns the frames that changed, null for all
   */
  async step(correct: (editor: MaskEditor) => Promise<Edit>): Promise<number[] | null> {
    const editor = this.openEditor;
    const before = editor.usesSession ? await editor.toResult() : null;
    const edit = await correct(editor);
    if (before && edit.corrections > 0) this.masksBeforeEdit.set(edit, before);
    return this.update(edit);
  }

  update(edit: Edit | null): number[] | null {
    this.target.result = this.openEditor.masks as CorrectionTarget['result'];
    return edit ? changedFrames(edit) : [];
  }

  async undo() {
    return this.undoCount() > 0 ? this.update(await this.openEditor.undo()) : [];
  }

  async redo() {
    return this.update(await this.openEditor.redo());
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
    const edit = await this.openEditor.paint(painted);
    return { edit, frames: changedFrames(edit) ?? [] };
  }

  /** Carries what was painted to other frames. */
  async carry({ edit, frames }: { edit: Edit; frames: number[] }, signal: AbortSignal, onFrame: (t: number) => void) {
    await this.openEditor.carry(edit, {
      signal,
      onFrame: ({ t }) => {
        frames.push(t);
        onFrame(t);
      },
    });
  }

  /** Returns a label that nothing has. */
  newLabel(): number {
    return this.openEditor.newLabel();
  }

  get openEditor(): MaskEditor {
    const { result, session } = this.target;
    if (!result) throw new PageError('unfinished');
    this.editor ??= editMasks(result, {
      ...(session ? { session } : {}),
      picture: (t) => this.pixels(t),
      engine: () => this.imageEngine(),
    });
    return this.editor;
  }

  imageEngine(): Promise<ImageEngine> {
    this.engine ??= createImageEngine();
    return this.engine;
  }

  /** The masks that a correction was made in. */
  masksBefore(edit: Edit): MaskEditor {
    const earlier = this.masksBeforeEdit.get(edit);
    if (earlier) return editMasks(earlier);
    const { editor } = this;
    if (!editor) throw new PageError('unfinished');
    const before = editMasks(editor.masks);
    const json = editor.toJSON();
    const paintEdits = this.edits.filter(({ corrections }) => corrections === 0);
    before.restore({ ...json, edits: json.edits.slice(0, paintEdits.indexOf(edit)) });
    return before;
  }

  /** The result with what was done over its masks. */
  applyTo(result: Result): Result {
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
      toTracksDat: async () => (this.target.session ? result : await editor.toResult()).toTracksDat(),
    };
  }

  /** Returns the frame at the size of the masks. */
  pixels(t: number): Promise<ImageData> {
    const { images, result } = this.target;
    if (!result) throw new PageError('unfinished');
    return images.pixels(t, result);
  }

  /** Edits of an earlier visit, which can be undone like those of this one. */
  restore(saved: SavedEdits) {
    this.openEditor.restore(saved);
  }

  /** An object is parted; by hand, the piece at a place becomes an object of its own. */
  async split(label: number, at?: Place) {
    if (!at && this.splitsAtPlace) throw new PageError('no-place');
    return this.step((editor) => editor.split(label, at));
  }

  /** Each stroke is a thing of its own. */
  splitStrokes(strokes: PackageStroke[]) {
    return this.step((editor) => editor.apart(strokes));
  }

  /** The objects that strokes lie on become one. */
  joinStrokes(strokes: PackageStroke[]) {
    return this.step((editor) => editor.together(strokes));
  }

  /**
   * What may be meant by a click, the smallest first.
   * @param place in pixels of the masks
   */
  async growRegions(t: number, place: { x: number; y: number }): Promise<{ regions: Region[]; likeliest: number }> {
    const engine = await this.imageEngine();
    const { numFrames, shots = [{ first: 0, last: numFrames - 1 }] } = this.openEditor;
    // Motion to the frame after, or the one before where that is another shot or none.
    const { first, last } = shots.find((shot) => t <= shot.last) ?? { first: 0, last: numFrames - 1 };
    const neighbourFrame = t < last ? t + 1 : Math.max(first, t - 1);
    const [picture, neighbour] = [await this.pixels(t), await this.pixels(neighbourFrame)];
    const [superpixels, flow] = [await engine.superpixels(picture), await engine.flow(picture, neighbour)];
    const candidates = await grownRegions({ superpixels, picture, flow }, place);
    const area = (pixels: Uint8Array) => pixels.reduce((sum, inside) => sum + inside, 0);
    const regions = [...candidates].sort((a, b) => area(decodeRuns(a)) - area(decodeRuns(b)));
    return { regions, likeliest: regions.indexOf(candidates[0]) };
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
function changedFrames({ corrections, table, paints }: Edit): number[] | null {
  if (corrections > 0 || Object.keys(table).length > 0) return null;
  return [...new Set(paints.flatMap(({ parts }) => [...parts.keys()]))];
}
