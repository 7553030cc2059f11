// Masks that a user corrects: objects merged, split and taken apart, pixels painted and erased, step by step, undone and done
// again. A session decides on its own masks; all other steps are edits over the masks, which stay as they are.

import { TraceCutError, checkedOptions, illegal, isPlainObject, wholeNumber } from '../../check/errors.js';
import { MAX_LABEL, type MaskSource, checkMasks, labelsOf } from '../../check/masks.js';
import { part } from '../../places.js';
import { type Place, type Stroke, mergeOf, splitOf, strokesOf } from '../../session/inputs.js';
import { clipTrajectories } from '../../session/report.js';
import { type Runs as Region, checkRuns, encodeRuns, forEachRun } from '../../session/runs.js';
import { divideRegions, pieceRegion, strokePixels } from './regions.js';
import type { WasmSource } from '../../check/options.js';
import type { Session } from '../../session/session.js';
import type { ImageEngine } from '../../stages/image.js';
import type { ClipTrajectories, VideoResult } from '../../video/result.js';
import type { Carried, CarryOptions, Picture } from './carry.js';

/** How masks are edited. */
export interface EditOptions {
  /**
   * Whose result the masks are: it is asked to merge, split and follow strokes, and cuts again, until something is
   * changed on the masks themselves.
   */
  session?: Session;
  /** Gives a frame's pixels as RGBA bytes, at any size; without it nothing is carried to other frames. */
  picture?: (t: number) => Picture | Promise<Picture>;
  /** Gives what computes the flow; saves opening one for each edit. */
  engine?: () => Promise<ImageEngine>;
  /** As for a session. */
  decoder?: WasmSource;
}

/** What an edit does in one frame; `evidence` says how sure it is to be meant there, 0 to 1: 1 where it was painted. */
export type Part = { region: Region; evidence: number };

/** Pixels of some frames get a label (0 erases): all of them, or those that have one of the labels `over`. */
export type Paint = { label: number; over: readonly number[] | null; parts: Map<number, Part> };

/** What a user wants otherwise. */
export type Correction =
  | { kind: 'paint' }
  | { kind: 'merge'; into: number; others: readonly number[] }
  | { kind: 'split'; label: number; at?: Place | undefined }
  | { kind: 'together' | 'apart'; strokes: readonly Stroke[] };

/**
 * What a step does to masks: `paints`, then `table`, which gives labels others in all frames. Where the session decided, it
 * is so many of its `corrections`, and no more.
 */
export type Change = { paints: Paint[]; table: Readonly<Record<number, number>>; corrections: number };

/** One step, undone as a whole. */
export type Edit = Correction & Change;

type SavedEdit = Correction & {
  table: Change['table'];
  paints: (Omit<Paint, 'parts'> & { parts: (Part & { t: number })[] })[];
};

/** Edits in a form for JSON. */
export type SavedEdits = { width: number; height: number; numFrames: number; edits: object[] };

/**
 * Masks with edits over them: wherever masks are taken, an editor may stand. Regions are kept as runs; the masks
 * themselves are made when they are asked for.
 */
export class MaskEditor {
  #masks;
  #options;
  #done: Edit[] = [];
  /** What was undone, the last first to be done again. */
  #undone: Edit[] = [];
  /** The labels of the masks below. */
  #below: Set<number> | undefined;

  /** Width of the masks in pixels. */
  width: number;
  /** Height of the masks in pixels. */
  height: number;
  /** Number of frames. */
  numFrames: number;
  /** Stretches of frames without a cut, where they are known. */
  shots: readonly { first: number; last: number }[] | undefined;
  /** The time of each frame in seconds, where known. */
  times: ArrayLike<number> | null;
  /** When the last frame ends, in seconds, where known. */
  end: number | null;

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
  }

  /** The masks below the edits: of a session, its result as corrected. */
  get masks() {
    return this.#masks;
  }

  /** The edits in force, first to last. */
  get edits(): readonly Edit[] {
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

  /** Whether the session decides on the next correction: it knows nothing of what was changed on the masks themselves. */
  get usesSession() {
    return this.#options.session !== undefined && this.#done.every(({ corrections }) => corrections > 0);
  }

  /** The trajectories of the masks, where they have some, each with the label of its object. */
  get trajectories(): ClipTrajectories | undefined {
    return clipTrajectories(this.#masks, (label) => this.labelOf(label));
  }

  /** Returns what a label of the masks below is now. */
  labelOf(label: number): number {
    return this.#done.reduce((now, { table }) => table[now] ?? now, label);
  }

  /** The mask of frame `t` with all edits, a copy. */
  labels(t: number): Uint8Array<ArrayBuffer> {
    const labels = Uint8Array.from(labelsOf(this.#masks, t));
    for (const edit of this.#done) apply(edit, t, labels);
    return labels;
  }

  /**
   * A label that nothing has in any frame.
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
   * Makes other objects a part of object `into`; with `into` = 0 they become background.
   * @param into 0 to 255
   * @param others 1 to 255
   */
  async merge(into: number, others: number | readonly number[]): Promise<Edit> {
    const list = [others].flat();
    if (list.length === 0) throw illegal('param', 'others', others, 'a label or more');
    for (const one of list) mergeOf(into, one);
    return this.#do({ kind: 'merge', into, others: list }, async () => ({ table: tableOf(into, list) }));
  }

  /**
   * Parts an object. The session parts it where its motion and its extent are weakest; without it the piece at a place of
   * its mask becomes an object of its own.
   * @param label 0 to 255; the background, 0, only with a session
   */
  async split(label: number, at?: Place): Promise<Edit> {
    if (at) splitOf(label, at, this);
    return this.#do({ kind: 'split', label, at }, async () => {
      if (!at || label === 0)
        throw new TraceCutError('param', 'only an object can be split, at a place of the piece that is another thing');
      const labels = this.labels(at.t);
      if (labels[Math.round(at.y) * this.width + Math.round(at.x)] !== label)
        throw illegal('param', 'at', at, `a place of object ${label}`);
      return this.#parted(at.t, label, [pieceRegion({ labels, width: this.width, height: this.height }, at)]);
    });
  }

  /**
   * Each of these strokes is a thing of its own. The session decides by motion and place what goes with which; without it
   * each pixel of the object goes to the nearest stroke, and all but the first become objects.
   * @param strokes 2 to 255; without a session in one frame
   */
  async apart(strokes: readonly Stroke[]): Promise<Edit> {
    const list = this.#copied('apart', strokes);
    return this.#do({ kind: 'apart', strokes: list }, async () => {
      const t = Number(list[0]?.t);
      if (list.some((stroke) => stroke.t !== t))
        throw new TraceCutError('param', 'the strokes lie in different frames: paint all of them in one');
      const { label, regions } = await divideRegions(this.labels(t), list, this, this.#options.decoder);
      return this.#parted(t, label, regions.slice(1));
    });
  }

  /**
   * All that these strokes touch is one thing: the objects that they lie over become one, with the lowest label. A session
   * adds what else is under them.
   * @param strokes 1 to 255
   */
  async together(strokes: readonly Stroke[]): Promise<Edit> {
    const list = this.#copied('together', strokes);
    return this.#do({ kind: 'together', strokes: list }, async () => {
      const counts = await Promise.all(list.map((stroke) => this.labelsUnder(stroke)));
      const labels = Array.from({ length: MAX_LABEL }, (_, k) => k + 1).filter((one) => counts.some((has) => has[one]));
      const [into = 0, ...others] = labels;
      if (others.length === 0)
        throw new TraceCutError(
          'param',
          'the strokes lie on one object at most: paint over each of those that are one',
        );
      return { table: tableOf(into, others) };
    });
  }

  /**
   * Gives pixels of one frame a label.
   * @param painted.label 1 to 255; 0 erases
   * @param painted.stroke what a brush covers
   * @param painted.t or the pixels of this frame
   * @param painted.region that are meant, as `encodeRuns` makes it of 1 inside and 0 outside
   * @param painted.over only pixels that have one of these labels; all where it is left out
   */
  async paint(painted: {
    label: number;
    stroke?: Stroke;
    t?: number;
    region?: Region;
    over?: readonly number[];
  }): Promise<Edit> {
    if (!isPlainObject(painted)) throw illegal('param', 'painted', painted, 'an object {label, stroke}');
    const { label, stroke, over = null } = painted;
    const t = stroke ? stroke.t : wholeNumber('param', 't', painted.t, 0, this.numFrames - 1);
    const region = stroke
      ? encodeRuns(await strokePixels(stroke, 'stroke', this, this.#options.decoder))
      : checkRuns('region', painted.region, this.width * this.height);
    return this.#push({ kind: 'paint' }, { paints: [{ label, over, parts: new Map([[t, { region, evidence: 1 }]]) }] });
  }

  /**
   * Carries what an edit paints to the frames before and after it, within the shot, along the optical flow, as long as the
   * picture there looks like what it came from. It stays one step.
   */
  async carry(edit: Edit, options: CarryOptions = {}): Promise<Carried> {
    const { picture, engine } = this.#options;
    if (!picture)
      throw new TraceCutError('state', 'nothing can be carried without pictures: editMasks(masks, {picture})');
    return (await part(import('./carry.js'))).carry(this, edit, { ...options, picture }, engine);
  }

  /**
   * Adds another frame to an edit that is in force: part of the same step, undone with it.
   * @param evidence 0 to 1
   * @param paint which of its paints; the first if not given
   */
  extend(edit: Edit, t: number, region: Region, evidence: number, paint: Paint | undefined = edit.paints?.[0]) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    checkRuns('region', region, this.width * this.height);
    if (!paint || !this.#done.includes(edit))
      throw new TraceCutError('state', 'only a painted edit that is in force can go on in other frames');
    paint.parts.set(t, { region, evidence });
  }

  /**
   * Takes the last edit back.
   * @returns null where there was none
   */
  async undo(): Promise<Edit | null> {
    const edit = this.#done.at(-1);
    if (!edit) return null;
    await this.#takeBack(edit.corrections);
    this.#done.pop();
    this.#undone.push(edit);
    return edit;
  }

  /**
   * Does again what was undone last.
   * @returns null where there was nothing
   */
  async redo(): Promise<Edit | null> {
    const edit = this.#undone.at(-1);
    if (!edit) return null;
    if (edit.corrections > 0) await this.#ask(edit);
    this.#undone.pop();
    this.#done.push(edit);
    return edit;
  }

  /**
   * Returns the masks with all edits as a result of their own, which no longer knows them.
   * @param frameRate frames per second, where the masks have no times; 25 if not given
   */
  async toResult(frameRate?: number): Promise<VideoResult> {
    return (await part(import('./project.js'))).resultOf(this, frameRate);
  }

  /** The edits in force, for `restore`, but for those of the session, which `masks` have. */
  toJSON(): SavedEdits {
    const own = this.#done.filter(({ corrections }) => corrections === 0);
    const edits = own.map((edit) => ({
      ...edit,
      paints: edit.paints.map((paint) => ({
        ...paint,
        parts: [...paint.parts].map(([t, { region, evidence }]) => ({ t, region: [...region], evidence })),
      })),
    }));
    return { width: this.width, height: this.height, numFrames: this.numFrames, edits };
  }

  /**
   * Does saved edits, after those that are in force.
   * @param saved as `toJSON` gave it, of masks of this size
   */
  restore(saved: SavedEdits) {
    const { width, height, numFrames } = this;
    const size = isPlainObject(saved) ? `${saved.width} × ${saved.height} × ${saved.numFrames}` : 'nothing';
    if (size !== `${width} × ${height} × ${numFrames}`)
      throw new TraceCutError('data', `these edits are of ${size} (expected ${width} × ${height} × ${numFrames})`);
    // Checked as a whole before anything is done: nothing is half restored.
    const trial = new MaskEditor(this.#masks, {});
    for (const edit of savedList('edits', saved.edits as SavedEdit[])) {
      if (!isPlainObject(edit.table)) throw illegal('data', 'table', edit.table, 'the label that each label becomes');
      const paints = savedList('paints', edit.paints).map((one) => {
        const parts = savedList('parts', one.parts).map(({ t, region, evidence }) => {
          const runs = checkRuns('region', Uint32Array.from(region ?? []), width * height);
          return [wholeNumber('data', 't', t, 0, numFrames - 1), { region: runs, evidence }] as const;
        });
        return { ...one, parts: new Map(parts) };
      });
      trial.#push(edit, { paints, table: edit.table });
    }
    this.#done.push(...trial.#done);
    this.#undone = [];
  }

  /**
   * Does a correction: by the session as long as that knows the masks, else on the masks.
   * @param change what it does to the masks
   */
  async #do(correction: Correction, change: () => Promise<Partial<Change>>): Promise<Edit> {
    if (this.usesSession) return this.#push(correction, { corrections: await this.#ask(correction) });
    const edit = this.#push(correction, await change());
    if (edit.paints.length === 0 || !this.#options.picture) return edit;
    try {
      await this.carry(edit);
      return edit;
    } catch (error) {
      this.#done = this.#done.filter((one) => one !== edit);
      throw error;
    }
  }

  #push(correction: Correction, change: Partial<Change>) {
    const edit: Edit = { ...correction, paints: [], table: {}, corrections: 0, ...change };
    for (const { label, over } of edit.paints) {
      wholeNumber('param', 'label', label, 0, MAX_LABEL);
      over?.forEach((one, k) => wholeNumber('param', `over[${k}]`, one, 0, MAX_LABEL));
    }
    for (const label of Object.entries(edit.table).flat()) wholeNumber('param', 'a label', Number(label), 0, MAX_LABEL);
    this.#done.push(edit);
    this.#undone = [];
    return edit;
  }

  #copied(kind: 'together' | 'apart', strokes: readonly Stroke[]): Stroke[] {
    strokesOf(kind, strokes, this);
    return strokes.map(({ t, points, radius }) => ({ t, points: Array.from(points), radius }));
  }

  /** Asks the session; what it refuses on the way leaves nothing half done. */
  async #ask(correction: Correction): Promise<number> {
    let count = 0;
    try {
      for await (const result of answers(this.#options.session!, correction)) {
        this.#masks = result;
        count += 1;
      }
    } catch (error) {
      await this.#takeBack(count);
      throw error;
    }
    this.#below = undefined;
    return count;
  }

  async #takeBack(corrections: number) {
    for (let k = 0; k < corrections; k += 1) this.#masks = await this.#options.session!.undo();
    if (corrections > 0) this.#below = undefined;
  }

  /** Regions of an object that become objects. */
  #parted(t: number, label: number, regions: Region[]) {
    const labels = this.#newLabels(regions.length);
    const part = (region: Region) => new Map([[t, { region, evidence: 1 }]]);
    return {
      paints: regions.map((region, k) => ({ label: Number(labels[k]), over: [label], parts: part(region) })),
    };
  }

  #newLabels(count: number) {
    const used = new Set(this.#used());
    const free = Array.from({ length: MAX_LABEL }, (_, k) => k + 1).filter((label) => !used.has(label));
    if (free.length < count)
      throw new TraceCutError('state', `all ${MAX_LABEL} labels are in use; merge or erase objects first`);
    return free.slice(0, count);
  }

  *#used() {
    this.#below ??= new Set(this.#labelsBelow());
    yield* this.#below;
    for (const { table, paints } of this.#done) {
      yield* Object.values(table);
      for (const { label } of paints) yield label;
    }
  }

  *#labelsBelow() {
    for (let t = 0; t < this.numFrames; t += 1) yield* new Set(labelsOf(this.#masks, t));
  }
}

/** Asks a session for a correction: it merges one object at a time. */
async function* answers(session: Session, correction: Correction) {
  if (correction.kind === 'merge') for (const one of correction.others) yield await session.merge(correction.into, one);
  if (correction.kind === 'split') yield await session.split(correction.label, correction.at);
  if (correction.kind === 'together' || correction.kind === 'apart')
    yield await session[correction.kind](correction.strokes);
}

function savedList<T>(name: string, list: readonly T[]): readonly T[] {
  if (!Array.isArray(list) || !list.every(isPlainObject)) throw illegal('data', name, list, 'a list of objects');
  return list;
}

function tableOf(into: number, others: readonly number[]): Record<number, number> {
  return Object.fromEntries(others.map((one) => [one, into]));
}

function apply({ paints, table }: Edit, t: number, labels: Uint8Array) {
  for (const { label, over, parts } of paints) {
    const painted = parts.get(t);
    if (!painted) continue;
    const has = over && new Set(over);
    forEachRun(painted.region, (inside, from, to) => {
      if (!inside) return;
      if (!has) labels.fill(label, from, to);
      else for (let p = from; p < to; p += 1) if (has.has(Number(labels[p]))) labels[p] = label;
    });
  }
  if (Object.keys(table).length === 0) return;
  const all = Uint8Array.from({ length: MAX_LABEL + 1 }, (_, label) => table[label] ?? label);
  for (let p = 0; p < labels.length; p += 1) labels[p] = Number(all[Number(labels[p])]);
}

/**
 * Masks that can be merged, split, painted and erased, step by step, each of which can be undone.
 *
 * ```js
 * const editor = editMasks(result, { session, picture: (t) => frames[t] });
 * await editor.merge(1, [2, 3]);
 * const edit = await editor.paint({ label: 0, stroke: { t: 4, points: [100, 80, 120, 90], radius: 6 } });
 * await editor.carry(edit);
 * await maskZip(editor);
 * ```
 */
export function editMasks(masks: MaskSource, options?: EditOptions): MaskEditor {
  return new MaskEditor(masks, checkedOptions(options ?? {}, ['session', 'picture', 'engine', 'decoder']));
}
