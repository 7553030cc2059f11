// The user's corrections of a run: the package's mask editor, with undo and growing of regions.

import { createImageEngine, decodeRuns, editMasks, growRegions } from './library.js';
import { PageError } from './messages.js';
import type { ClipJob } from './clip-job.js';
import type {
  Edit,
  FrameFeatures,
  FrameRange,
  ImageEngine,
  MaskEditor,
  MaskSource,
  Place,
  Region,
  SavedEdits,
  Stroke as PackageStroke,
} from './library.js';
import type { Result } from './presence.js';

/** A stroke that can be extended. */
export type Stroke = PackageStroke & { points: number[] };

/** The frames that an edit is carried to, and how sure it must be there, 0 to 1. */
type CarryLimits = { first?: number; last?: number; minEvidence?: number };

/** Frames whose features are kept. */
const MAX_FEATURES = 2;

/** The job that is corrected; `result` is replaced when its session corrects. */
type CorrectionTarget = Pick<ClipJob, 'images' | 'result' | 'session'>;

export class Corrections {
  /** Corrections carried over from the previous run, which are one undo step with this run. */
  carriedCount = 0;
  editor: MaskEditor | null = null;
  engine: Promise<ImageEngine> | null = null;
  masksBeforeEdit = new WeakMap<Edit, MaskSource>();
  /** Features of the last frames, the newest last. */
  features = new Map<number, Promise<FrameFeatures>>();

  constructor(public target: CorrectionTarget) {}

  get edits(): readonly Edit[] {
    return this.editor?.edits ?? [];
  }

  undoCount() {
    return this.edits.length - this.carriedCount;
  }

  redoCount() {
    return this.editor?.redoable ?? 0;
  }

  /** True if the session made some of the corrections. */
  get changesResult() {
    return this.edits.some(({ corrections }) => corrections > 0);
  }

  /** The corrected masks; null before there is a result. */
  get masks() {
    return this.edits.length > 0 ? this.editor : this.target.result;
  }

  /** True if objects can only be split at a clicked place. */
  get splitsAtPlace() {
    return this.editor ? !this.editor.usesSession : this.target.session === null;
  }

  /**
   * Applies a correction as one undo step.
   * @returns the changed frames; null for all
   */
  async applyStep(correct: (editor: MaskEditor) => Promise<Edit>): Promise<number[] | null> {
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

  join(into: number, others: number[]) {
    return this.applyStep((editor) => editor.merge(into, others));
  }

  /**
   * Paints in one frame.
   * @returns the argument for `carry` and `trim`
   */
  paint(painted: Parameters<MaskEditor['paint']>[0]): Promise<Edit> {
    return this.openEditor.paint(painted);
  }

  /**
   * Propagates a painted edit to other frames.
   * @param limits the frames that it is carried to; as far as the picture supports it if not given
   */
  async carry(edit: Edit, signal: AbortSignal, onFrame: (t: number) => void, limits: CarryLimits = {}) {
    await this.openEditor.carry(edit, { ...limits, signal, onFrame: ({ t }) => onFrame(t) });
  }

  /**
   * Removes a painted edit from the frames outside of a range.
   * @returns these frames
   */
  trim(edit: Edit, range: { first: number; last: number }): number[] {
    const before = framesOf(edit);
    this.openEditor.trim(edit, range);
    const frames = new Set(framesOf(edit));
    return before.filter((t) => !frames.has(t));
  }

  /**
   * Replaces the masks of a range of frames by masks interpolated from the frames before and after it, or carries the mask
   * before it on, as one step.
   * @returns the changed frames; null for all
   */
  async interpolate(
    range: FrameRange,
    options: { sides: 'both' | 'before'; signal: AbortSignal; onFrame: () => void },
  ): Promise<number[] | null> {
    return this.update(await this.openEditor.interpolate(range, options));
  }

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

  /** Returns the result with painted edits applied. */
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
      // Tracks of a session carry clusters.
      toTracksDat: async () => (this.target.session ? result : await editor.toResult()).toTracksDat(),
    };
  }

  /** Returns a frame at the size of the masks. */
  pixels(t: number): Promise<ImageData> {
    const { images, result } = this.target;
    if (!result) throw new PageError('unfinished');
    return images.pixels(t, result);
  }

  /** Restores saved edits, which can be undone. */
  restore(saved: SavedEdits) {
    this.openEditor.restore(saved);
  }

  /** Splits an object. Without a session, the connected piece at a place becomes a new object. */
  async split(label: number, at?: Place) {
    if (!at && this.splitsAtPlace) throw new PageError('no-place');
    return this.applyStep((editor) => editor.split(label, at));
  }

  /** Separates the objects under the strokes. */
  splitStrokes(strokes: PackageStroke[]) {
    return this.applyStep((editor) => editor.apart(strokes));
  }

  /** Returns the objects under strokes, without the background. */
  async objectsUnder(strokes: PackageStroke[]): Promise<number[]> {
    const counts = await Promise.all(strokes.map((stroke) => this.openEditor.labelsUnder(stroke)));
    const labels = Array.from(counts[0] ?? [], (_, label) => label);
    return labels.filter((label) => label > 0 && counts.some((pixels) => pixels[label] > 0));
  }

  /** Joins the objects under the strokes. */
  joinStrokes(strokes: PackageStroke[]) {
    return this.applyStep((editor) => editor.together(strokes));
  }

  /** Returns the features of a frame, computed once. */
  frameFeatures(t: number): Promise<FrameFeatures> {
    const features = this.features.get(t) ?? this.computeFeatures(t);
    this.features.delete(t);
    this.features.set(t, features);
    if (this.features.size > MAX_FEATURES) this.features.delete(this.features.keys().next().value!);
    features.catch(() => this.features.delete(t));
    return features;
  }

  async computeFeatures(t: number): Promise<FrameFeatures> {
    const engine = await this.imageEngine();
    // Motion to the next frame, or from the previous one at the end of a shot.
    const { first, last } = this.openEditor.shotOf(t);
    const neighbourFrame = t < last ? t + 1 : Math.max(first, t - 1);
    const [picture, neighbour] = [await this.pixels(t), await this.pixels(neighbourFrame)];
    return { superpixels: await engine.superpixels(picture), picture, flow: await engine.flow(picture, neighbour) };
  }

  /**
   * Grows candidate regions from a place.
   * @param place in pixels of the masks
   * @returns regions, smallest first, and the index of the likeliest
   */
  async growRegions(t: number, place: { x: number; y: number }): Promise<{ regions: Region[]; likeliest: number }> {
    const candidates = await growRegions(await this.frameFeatures(t), place);
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
    this.features.clear();
  }
}

/** Returns the frames that an edit changes; null for all. */
function changedFrames(edit: Edit): number[] | null {
  return edit.corrections > 0 || Object.keys(edit.table).length > 0 ? null : framesOf(edit);
}

/** Returns the frames that an edit paints, the painted one first. */
export function framesOf({ paints }: Edit): number[] {
  return [...new Set(paints.flatMap(({ parts }) => [...parts.keys()]))];
}
