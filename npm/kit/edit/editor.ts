// Masks that a user corrects: objects merged, split and separated, pixels painted and erased, step by step, with undo and
// redo. A session applies corrections to its own masks; all other steps are edits over masks that do not change.

import { TraceCutError, checkOptions, checkWholeNumber, illegal, isPlainObject } from '../../check/errors.js';
import { MAX_LABEL, type MaskSource, checkMasks, findShot, readLabels } from '../../check/masks.js';
import { loadPart } from '../../platform.js';
import { type Place, type Stroke, toMerge, toSplit, toStrokes } from '../../session/requests.js';
import { getTrajectories } from '../../session/report.js';
import { type Runs as Region, checkRuns, encodeRuns, forEachRun } from '../../session/serialize.js';
import { divideRegions, findPiece, strokePixels } from './regions.js';
import type { WasmSource } from '../../check/options.js';
import type { Session } from '../../session/session.js';
import type { ImageEngine } from '../../stages/image.js';
import type { ClipTrajectories, VideoResult } from '../../video/result.js';
import type { CarryOptions, CarryRange } from './carry.js';
import type { InterpolateOptions, Picture } from './motion.js';

/** Options of an editor. */
export interface EditOptions {
  /**
   * The session that computed the masks: it merges, splits and follows strokes, and cuts again, until the masks
   * themselves are edited.
   */
  session?: Session;
  /** Returns a frame's pixels as RGBA bytes, at any size; without it nothing is carried to other frames. */
  picture?: (t: number) => Picture | Promise<Picture>;
  /** Returns the engine that computes the flow; saves opening one for each edit. */
  engine?: () => Promise<ImageEngine>;
  /** As for a session. */
  decoder?: WasmSource;
}

/** A region of one frame that an edit changes; `evidence` is the confidence in it, 0 to 1: 1 where it was painted. */
export type Part = { region: Region; evidence: number };

/** Assigns a label (0 erases) to regions of some frames: to all pixels, or to those that have one of the labels `over`. */
export type Paint = { label: number; over: readonly number[] | null; parts: Map<number, Part> };

/** A user's correction. */
export type Correction =
  | { kind: 'paint' }
  | { kind: 'merge'; into: number; others: readonly number[] }
  | { kind: 'split'; label: number; at?: Place | undefined }
  | { kind: 'interpolate'; from: number; to: number; sides: 'before' | 'both' }
  | { kind: 'together' | 'apart'; strokes: readonly Stroke[] };

/**
 * The effect of a step: `paints`, then `table`, which maps labels to others in all frames. If the session applied it,
 * `corrections` is how many corrections of the session it took, and the rest is empty.
 */
export type Change = { paints: Paint[]; table: Readonly<Record<number, number>>; corrections: number };

/** One step, undone as a whole. */
export type Edit = Correction & Change;

type SavedEdit = Correction & {
  table: Change['table'];
  paints: (Omit<Paint, 'parts'> & { parts: (Part & { t: number })[] })[];
};

/** Edits as plain objects for JSON. */
export type SavedEdits = { width: number; height: number; numFrames: number; edits: object[] };

/** Masks with edits over them; an editor is accepted wherever masks are. Regions are kept as runs, masks made on request. */
export class MaskEditor {
  #masks;
  #options;
  #applied: Edit[] = [];
  /** Undone edits, the next to redo last. */
  #undone: Edit[] = [];
  /** The labels of the masks below the edits. */
  #originalLabels: Set<number> | undefined;

  /** Width of the masks in pixels. */
  width: number;
  /** Height of the masks in pixels. */
  height: number;
  /** Number of frames. */
  numFrames: number;
  /** Ranges of frames without a cut, if known. */
  shots: readonly { first: number; last: number }[] | undefined;
  /** The time of each frame in seconds, if known. */
  times: ArrayLike<number> | null;
  /** Time at which the last frame ends, in seconds, if known. */
  end: number | null;
  /** The frames whose masks should be looked at, before edits. */
  doubts: MaskSource['doubts'];

  constructor(masks: MaskSource, options: EditOptions) {
    checkMasks(masks);
    this.#masks = masks;
    this.#options = options;
    this.width = masks.width;
    this.height = masks.height;
    this.numFrames = masks.numFrames;
    this.shots = masks.shots;
    this.times = masks.times ?? null;
    this.end = masks.end ?? null;
    this.doubts = masks.doubts ?? null;
  }

  /** The masks below the edits; for a session its corrected result. */
  get masks() {
    return this.#masks;
  }

  /** The edits in force, first to last. */
  get edits(): readonly Edit[] {
    return this.#applied;
  }

  /** Number of edits that can be undone. */
  get undoable() {
    return this.#applied.length;
  }

  /** Number of edits that can be redone. */
  get redoable() {
    return this.#undone.length;
  }

  /** True if the session applies the next correction: it does not know edits of the masks themselves. */
  get usesSession() {
    return this.#options.session !== undefined && this.#applied.every(({ corrections }) => corrections > 0);
  }

  /** The trajectories of the masks, if any, each with the label of its object. */
  get trajectories(): ClipTrajectories | undefined {
    return getTrajectories(this.#masks, (label) => this.labelOf(label));
  }

  /** Returns the present label of an object of the masks below. */
  labelOf(label: number): number {
    return this.#applied.reduce((current, { table }) => table[current] ?? current, label);
  }

  /**
   * Returns the mask of frame `t` with all edits, a copy.
   * @param before only with the edits before this one
   */
  labels(t: number, before?: Edit): Uint8Array<ArrayBuffer> {
    const labels = Uint8Array.from(readLabels(this.#masks, t));
    for (const edit of this.#applied) {
      if (edit === before) break;
      applyEdit(edit, t, labels);
    }
    return labels;
  }

  /** Returns the first and the last frame of the shot of frame `t`. */
  shotOf(t: number): { first: number; last: number } {
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
    return findShot(this, t);
  }

  /**
   * Returns an unused label.
   * @returns 1 to 255
   */
  newLabel(): number {
    return this.#newLabels(1)[0] ?? 0;
  }

  /**
   * Counts the pixels of each label under a stroke.
   * @returns 256 numbers
   */
  async labelsUnder(stroke: Stroke): Promise<Uint32Array<ArrayBuffer>> {
    const counts = new Uint32Array(MAX_LABEL + 1);
    const pixels = await strokePixels(stroke, 'stroke', this, this.#options.decoder);
    const labels = this.labels(stroke.t);
    pixels.forEach((inside, p) => (counts[Number(labels[p])] = Number(counts[Number(labels[p])]) + inside));
    return counts;
  }

  /**
   * Merges other objects into object `into`; with `into` = 0 they become background.
   * @param into 0 to 255
   * @param others 1 to 255
   */
  async merge(into: number, others: number | readonly number[]): Promise<Edit> {
    const labels = [others].flat();
    if (labels.length === 0) throw illegal('param', 'others', others, 'a label or more');
    for (const label of labels) toMerge(into, label);
    return this.#apply({ kind: 'merge', into, others: labels }, async () => ({ table: createTable(into, labels) }));
  }

  /**
   * Splits an object. The session splits it where its motion and its extent are weakest; without a session the piece of
   * its mask at a place becomes a new object.
   * @param label 0 to 255; the background, 0, only with a session
   */
  async split(label: number, at?: Place): Promise<Edit> {
    if (at) toSplit(label, at, this);
    return this.#apply({ kind: 'split', label, at }, async () => {
      if (!at || label === 0)
        throw new TraceCutError('param', 'split needs an object and a place on the piece to separate');
      const labels = this.labels(at.t);
      if (labels[Math.round(at.y) * this.width + Math.round(at.x)] !== label)
        throw illegal('param', 'at', at, `a place of object ${label}`);
      return this.#separate(at.t, label, [findPiece({ labels, width: this.width, height: this.height }, at)]);
    });
  }

  /**
   * Makes each stroke an object of its own. The session assigns the rest by motion and place; without it each pixel of the
   * object goes to the nearest stroke, and all strokes but the first become new objects.
   * @param strokes 2 to 255; without a session in one frame
   */
  async apart(strokes: readonly Stroke[]): Promise<Edit> {
    const list = this.#copyStrokes('apart', strokes);
    return this.#apply({ kind: 'apart', strokes: list }, async () => {
      const t = Number(list[0]?.t);
      if (list.some((stroke) => stroke.t !== t))
        throw new TraceCutError('param', 'the strokes lie in different frames (expected one frame)');
      const { label, regions } = await divideRegions(this.labels(t), list, this, this.#options.decoder);
      return this.#separate(t, label, regions.slice(1));
    });
  }

  /**
   * Joins the objects under the strokes to one, with the lowest label. A session adds the other pixels under them.
   * @param strokes 1 to 255
   */
  async together(strokes: readonly Stroke[]): Promise<Edit> {
    const list = this.#copyStrokes('together', strokes);
    return this.#apply({ kind: 'together', strokes: list }, async () => {
      const counts = await Promise.all(list.map((stroke) => this.labelsUnder(stroke)));
      const labels = Array.from({ length: MAX_LABEL }, (_, k) => k + 1).filter((label) =>
        counts.some((count) => count[label]),
      );
      const [into = 0, ...others] = labels;
      if (others.length === 0) throw new TraceCutError('param', 'the strokes lie on fewer than two objects');
      return { table: createTable(into, others) };
    });
  }

  /**
   * Assigns a label to pixels of one frame.
   * @param painted.label 1 to 255; 0 erases
   * @param painted.stroke the pixels that a brush covers
   * @param painted.t or the frame of the pixels
   * @param painted.region and the pixels, as `encodeRuns` encodes 1 inside and 0 outside
   * @param painted.over only pixels that have one of these labels; all if not given
   */
  async paint(painted: {
    label: number;
    stroke?: Stroke;
    t?: number;
    region?: Region;
    over?: readonly number[];
  }): Promise<Edit> {
    const { label, stroke, over = null } = checkOptions(painted, ['label', 'stroke', 't', 'region', 'over']);
    const t = stroke ? stroke.t : checkWholeNumber('param', 't', painted.t, 0, this.numFrames - 1);
    const region = stroke
      ? encodeRuns(await strokePixels(stroke, 'stroke', this, this.#options.decoder))
      : checkRuns('region', painted.region, this.width * this.height);
    return this.#push({ kind: 'paint' }, { paints: [{ label, over, parts: new Map([[t, { region, evidence: 1 }]]) }] });
  }

  /**
   * Carries the regions of an edit along the optical flow to the frames before and after it within the shot, outward, as
   * long as colours and flow speak for the pixels that it changes. It stays one step.
   */
  async carry(edit: Edit, options: CarryOptions = {}): Promise<CarryRange> {
    checkOptions(options, ['first', 'last', 'minEvidence', 'signal', 'onFrame']);
    const { picture, engine } = this.#options;
    if (!picture) throw new TraceCutError('state', 'carry needs pictures: editMasks(masks, {picture})');
    return (await loadPart(import('./carry.js'))).carry(this, edit, { ...options, picture }, engine);
  }

  /**
   * Adds another frame to an edit in force: part of the same step, undone with it.
   * @param evidence 0 to 1
   * @param paint one of its paints; the first if not given
   */
  extend(edit: Edit, t: number, region: Region, evidence: number, paint: Paint | undefined = edit.paints?.[0]) {
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
    checkRuns('region', region, this.width * this.height);
    if (!paint || !this.#applied.includes(edit))
      throw new TraceCutError('state', 'only a painted edit in force can be extended');
    paint.parts.set(t, { region, evidence });
  }

  /**
   * Removes the parts of an edit in force outside of a range of frames. It stays one step.
   * @param range.first 0 to the painted frame
   * @param range.last the painted frame to `numFrames - 1`
   */
  trim(edit: Edit, { first, last }: { first: number; last: number }) {
    const [painted] = edit?.paints?.[0]?.parts.keys() ?? [];
    if (painted === undefined || !this.#applied.includes(edit))
      throw new TraceCutError('state', 'only a painted edit in force can be trimmed');
    checkWholeNumber('param', 'first', first, 0, painted);
    checkWholeNumber('param', 'last', last, painted, this.numFrames - 1);
    for (const { parts } of edit.paints) for (const t of [...parts.keys()]) if (t < first || t > last) parts.delete(t);
  }

  /**
   * Replaces the masks of a range of frames by the masks of the frames before and after it, moved along the optical
   * flow; the nearer frame has more weight. One step.
   * @param range.from 0 to `numFrames - 1`, and not the first frame of a shot
   * @param range.to one after the last frame, in the same shot
   * @param options.sides `before` takes only the frame before, and ends where objects no longer look like those in it
   */
  async interpolate(range: { from: number; to: number }, options: InterpolateOptions = {}): Promise<Edit> {
    checkOptions(options, ['sides', 'signal', 'onFrame']);
    const { picture, engine } = this.#options;
    if (!picture) throw new TraceCutError('state', 'interpolate needs pictures: editMasks(masks, {picture})');
    const { interpolate } = await loadPart(import('./motion.js'));
    const paints = await interpolate(this, range, { ...options, picture }, engine);
    return this.#push({ kind: 'interpolate', ...range, sides: options.sides ?? 'both' }, { paints });
  }

  /**
   * Undoes the last edit.
   * @returns null if there was none
   */
  async undo(): Promise<Edit | null> {
    const edit = this.#applied.at(-1);
    if (!edit) return null;
    await this.#undoCorrections(edit.corrections);
    this.#applied.pop();
    this.#undone.push(edit);
    return edit;
  }

  /**
   * Applies the last undone edit again.
   * @returns null if there was none
   */
  async redo(): Promise<Edit | null> {
    const edit = this.#undone.at(-1);
    if (!edit) return null;
    if (edit.corrections > 0) await this.#correct(edit);
    this.#undone.pop();
    this.#applied.push(edit);
    return edit;
  }

  /**
   * Returns the masks with all edits as a separate result.
   * @param frameRate frames per second, if the masks have no times; 25 if not given
   */
  async toResult(frameRate?: number): Promise<VideoResult> {
    return (await loadPart(import('./project.js'))).toVideoResult(this, frameRate);
  }

  /** Returns the edits in force for `restore`, without the session's corrections, which `masks` include. */
  toJSON(): SavedEdits {
    const maskEdits = this.#applied.filter(({ corrections }) => corrections === 0);
    const edits = maskEdits.map((edit) => ({
      ...edit,
      paints: edit.paints.map((paint) => ({
        ...paint,
        parts: [...paint.parts].map(([t, { region, evidence }]) => ({ t, region: [...region], evidence })),
      })),
    }));
    return { width: this.width, height: this.height, numFrames: this.numFrames, edits };
  }

  /**
   * Applies saved edits after the edits in force.
   * @param saved as returned by `toJSON`, of masks of this size
   */
  restore(saved: SavedEdits) {
    const { width, height, numFrames } = this;
    const size = isPlainObject(saved) ? `${saved.width} × ${saved.height} × ${saved.numFrames}` : 'nothing';
    if (size !== `${width} × ${height} × ${numFrames}`)
      throw new TraceCutError('data', `the edits are for ${size} (expected ${width} × ${height} × ${numFrames})`);
    // All is checked before anything is applied: nothing is half restored.
    const trial = new MaskEditor(this.#masks, {});
    for (const edit of checkList('edits', saved.edits as SavedEdit[])) {
      if (!isPlainObject(edit.table)) throw illegal('data', 'table', edit.table, 'the label that each label becomes');
      const paints = checkList('paints', edit.paints).map((paint) => {
        const parts = checkList('parts', paint.parts).map(({ t, region, evidence }) => {
          const runs = checkRuns('region', Uint32Array.from(region ?? []), width * height);
          return [checkWholeNumber('data', 't', t, 0, numFrames - 1), { region: runs, evidence }] as const;
        });
        return { ...paint, parts: new Map(parts) };
      });
      trial.#push(edit, { paints, table: edit.table });
    }
    this.#applied.push(...trial.#applied);
    this.#undone = [];
  }

  /**
   * Applies a correction: by the session as long as it knows the masks, else on the masks.
   * @param change computes the effect on the masks
   */
  async #apply(correction: Correction, change: () => Promise<Partial<Change>>): Promise<Edit> {
    if (this.usesSession) return this.#push(correction, { corrections: await this.#correct(correction) });
    const edit = this.#push(correction, await change());
    if (edit.paints.length === 0 || !this.#options.picture) return edit;
    try {
      await this.carry(edit);
      return edit;
    } catch (error) {
      this.#applied = this.#applied.filter((applied) => applied !== edit);
      throw error;
    }
  }

  #push(correction: Correction, change: Partial<Change>) {
    const edit: Edit = { ...correction, paints: [], table: {}, corrections: 0, ...change };
    for (const { label, over } of edit.paints) {
      checkWholeNumber('param', 'label', label, 0, MAX_LABEL);
      over?.forEach((old, k) => checkWholeNumber('param', `over[${k}]`, old, 0, MAX_LABEL));
    }
    for (const label of Object.entries(edit.table).flat())
      checkWholeNumber('param', 'a label', Number(label), 0, MAX_LABEL);
    this.#applied.push(edit);
    this.#undone = [];
    return edit;
  }

  #copyStrokes(kind: 'together' | 'apart', strokes: readonly Stroke[]): Stroke[] {
    toStrokes(kind, strokes, this);
    return strokes.map(({ t, points, radius }) => ({ t, points: Array.from(points), radius }));
  }

  /** Lets the session apply a correction; if it fails on the way, nothing is left half done. */
  async #correct(correction: Correction): Promise<number> {
    let count = 0;
    try {
      for await (const result of applyToSession(this.#options.session!, correction)) {
        this.#masks = result;
        count += 1;
      }
    } catch (error) {
      await this.#undoCorrections(count);
      throw error;
    }
    this.#originalLabels = undefined;
    return count;
  }

  async #undoCorrections(corrections: number) {
    for (let k = 0; k < corrections; k += 1) this.#masks = await this.#options.session!.undo();
    if (corrections > 0) this.#originalLabels = undefined;
  }

  /** Returns the change that makes regions of an object new objects. */
  #separate(t: number, label: number, regions: Region[]) {
    const labels = this.#newLabels(regions.length);
    const createParts = (region: Region) => new Map([[t, { region, evidence: 1 }]]);
    return {
      paints: regions.map((region, k) => ({ label: Number(labels[k]), over: [label], parts: createParts(region) })),
    };
  }

  #newLabels(count: number) {
    const usedLabels = new Set(this.#usedLabels());
    const free = Array.from({ length: MAX_LABEL }, (_, k) => k + 1).filter((label) => !usedLabels.has(label));
    if (free.length < count)
      throw new TraceCutError('state', `all ${MAX_LABEL} labels are in use; merge or erase objects first`);
    return free.slice(0, count);
  }

  *#usedLabels() {
    this.#originalLabels ??= new Set(this.#scanLabels());
    yield* this.#originalLabels;
    for (const { table, paints } of this.#applied) {
      yield* Object.values(table);
      for (const { label } of paints) yield label;
    }
  }

  *#scanLabels() {
    for (let t = 0; t < this.numFrames; t += 1) yield* new Set(readLabels(this.#masks, t));
  }
}

/** Applies a correction to a session, which merges one object at a time; yields the result of each step. */
async function* applyToSession(session: Session, correction: Correction) {
  if (correction.kind === 'merge')
    for (const label of correction.others) yield await session.merge(correction.into, label);
  if (correction.kind === 'split') yield await session.split(correction.label, correction.at);
  if (correction.kind === 'together' || correction.kind === 'apart')
    yield await session[correction.kind](correction.strokes);
}

function checkList<T>(name: string, list: readonly T[]): readonly T[] {
  if (!Array.isArray(list) || !list.every(isPlainObject)) throw illegal('data', name, list, 'a list of objects');
  return list;
}

function createTable(into: number, others: readonly number[]): Record<number, number> {
  return Object.fromEntries(others.map((label) => [label, into]));
}

function applyEdit({ paints, table }: Edit, t: number, labels: Uint8Array) {
  for (const { label, over, parts } of paints) {
    const part = parts.get(t);
    if (!part) continue;
    const replaceable = over && new Set(over);
    forEachRun(part.region, (inside, from, to) => {
      if (!inside) return;
      if (!replaceable) labels.fill(label, from, to);
      else for (let p = from; p < to; p += 1) if (replaceable.has(Number(labels[p]))) labels[p] = label;
    });
  }
  if (Object.keys(table).length === 0) return;
  const newLabels = Uint8Array.from({ length: MAX_LABEL + 1 }, (_, label) => table[label] ?? label);
  for (let p = 0; p < labels.length; p += 1) labels[p] = Number(newLabels[Number(labels[p])]);
}

/**
 * Opens an editor of masks: they can be merged, split, painted and erased in steps, each of which can be undone.
 *
 * ```js
 * const editor = editMasks(result, { session, picture: (t) => frames[t] });
 * await editor.merge(1, [2, 3]);
 * const edit = await editor.paint({ label: 0, stroke: { t: 4, points: [100, 80, 120, 90], radius: 6 } });
 * await editor.carry(edit);
 * await masksZip(editor);
 * ```
 */
export function editMasks(masks: MaskSource, options?: EditOptions): MaskEditor {
  return new MaskEditor(masks, checkOptions(options ?? {}, ['session', 'picture', 'engine', 'decoder']));
}
