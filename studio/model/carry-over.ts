// Repeats the corrections of one run in the result of another run of the clip, as far as they still apply. Objects
// are matched by overlap. Loaded when a corrected result is run again.

import { decodeRuns, encodeRuns, yieldThread } from './library.js';
import { objectName } from './palette.js';
import type { ClipJob } from './clip-job.js';
import type { Corrections } from './corrections.js';
import type { Edit, MaskEditor, MaskSource, Region, Stroke } from './library.js';
import type { Trim } from './source.js';

/** Smallest intersection over union of matching objects; chosen by eye. */
const MIN_OVERLAP = 0.5;

/** Longest time without yielding to the page, in milliseconds: less than a frame at 60 Hz. */
const SLICE_MS = 12;

/**
 * @param from a result and its hidden objects
 * @param to another result, without corrections, which receives them
 * @returns the hidden objects of the new result, and descriptions of corrections that no longer apply
 */
export async function carryOver(
  { job, hidden }: { job: ClipJob; hidden: ReadonlySet<number> },
  to: ClipJob,
): Promise<{ hidden: Set<number>; dropped: string[] }> {
  const { corrections } = job;
  const dropped: string[] = job.hasEarlierCorrections ? ['earlier corrections'] : [];
  for (const edit of corrections.edits) {
    const applies = await applyEdit(edit, corrections.masksBefore(edit), job, to).catch(() => false);
    if (!applies) dropped.push(describeEdit(edit));
  }
  to.corrections.carriedCount = to.corrections.edits.length;
  to.presence = null;
  const newHidden = new Set<number>();
  const last = corrections.masks;
  const match = hidden.size > 0 && last ? await matchObjects(last, job, to).catch(() => null) : null;
  for (const object of hidden) {
    const newObject = object === 0 ? 0 : (match?.newLabelOf(object) ?? null);
    if (newObject !== null) newHidden.add(newObject);
    else if (match?.isThere(object)) dropped.push(`removing ${objectName(object)}`);
  }
  return { hidden: newHidden, dropped };
}

/**
 * Repeats a correction in the new result.
 * @returns false if it does not apply
 */
async function applyEdit(edit: Edit, old: MaskEditor, from: ClipJob, to: ClipJob): Promise<boolean> {
  const { corrections } = to;
  const match = await matchObjects(old, from, to);
  const mapping = new ResultMapping(old, from.trim, to);
  if (edit.kind === 'merge') return join(corrections, match, edit.into, edit.others);
  if (edit.kind === 'paint') return repaint(edit, to, match, mapping);
  if (edit.kind === 'interpolate') {
    const [from, last] = [mapping.frame(edit.from), mapping.frame(edit.to - 1)];
    if (from === null || last === null) return false;
    const { signal } = new AbortController();
    await corrections.interpolate({ from, to: last + 1 }, { sides: edit.sides, signal, onFrame: () => {} });
    return true;
  }
  if (edit.kind === 'split') {
    const label = match.newLabelOf(edit.label);
    const at = edit.at && mapping.at(edit.at);
    if (label === null || at === null) return false;
    await corrections.split(label, at);
    return true;
  }
  const strokes = edit.strokes.map((stroke) => mapping.stroke(stroke));
  const objects = await Promise.all(
    edit.strokes.map(async (stroke) => match.newLabelOf(largestLabel(await old.labelsUnder(stroke)))),
  );
  if (objects.includes(null) || strokes.includes(null)) return false;
  if (edit.kind === 'apart') await corrections.splitStrokes(strokes as Stroke[]);
  else await corrections.joinStrokes(strokes as Stroke[]);
  return true;
}

async function join(corrections: Corrections, match: ObjectMatch, into: number, others: readonly number[]) {
  const target = match.newLabelOf(into);
  if (target === null) return false;
  const matched = others.map((object) => match.newLabelOf(object));
  const sources = [...new Set(matched)].filter((object) => object !== null && object !== target);
  if (sources.length > 0) await corrections.join(target, sources as number[]);
  // Objects already inside the target need no join.
  return others.every((object, k) => matched[k] !== null || match.isWithin(object, target));
}

async function repaint(
  { paints: [{ label, over, parts }] }: Edit,
  to: ClipJob,
  match: ObjectMatch,
  mapping: ResultMapping,
) {
  const { corrections } = to;
  const isNew = label > 0 && !match.isThere(label);
  const newLabel = isNew ? corrections.newLabel() : match.newLabelOf(label);
  const targets = over?.map((object) => match.newLabelOf(object));
  const regions = [...parts].flatMap(([t, { region }]) => mapping.region(t, region));
  if (newLabel === null || targets?.includes(null) || regions.length === 0) return false;
  const [[t, region], ...otherRegions] = regions;
  const edit = await corrections.paint({
    ...{ label: newLabel, t, region },
    ...(targets ? { over: targets as number[] } : {}),
  });
  if (isContiguous(regions))
    for (const [at, otherRegion] of otherRegions) corrections.openEditor.extend(edit, at, otherRegion, 1);
  // The old edit skipped frames in between.
  else await corrections.carry(edit, new AbortController().signal, () => {});
  return true;
}

function isContiguous(parts: [number, Region][]) {
  const frames = parts.map(([t]) => t);
  return Math.max(...frames) - Math.min(...frames) === frames.length - 1;
}

function largestLabel(counts: Uint32Array): number {
  return counts.indexOf(Math.max(...counts));
}

/** Maps frames and positions of one result to another of different size or trim. */
class ResultMapping {
  size: { width: number; height: number };
  scale: number[];
  frame: (t: number) => number | null;

  constructor(
    readonly old: { width: number; height: number },
    trim: Trim,
    to: ClipJob,
  ) {
    const { width, height } = to.corrections.masks!;
    this.size = { width, height };
    this.scale = [width / old.width, height / old.height];
    this.frame = (t: number) => mapFrame(t, trim, to);
  }

  at({ t, x, y }: { t: number; x: number; y: number }): { t: number; x: number; y: number } | null {
    const now = this.frame(t);
    const [px, py] = this.point([x, y]);
    return now === null ? null : { t: now, x: px, y: py };
  }

  point({ 0: x, 1: y }: ArrayLike<number>): [number, number] {
    const [sx, sy] = this.scale;
    return [(x + 0.5) * sx - 0.5, (y + 0.5) * sy - 0.5];
  }

  stroke({ t, points, radius }: Stroke): Stroke | null {
    const now = this.frame(t);
    if (now === null) return null;
    const list = Array.from(points);
    const mapped = list.flatMap((_, k) => (k % 2 === 0 ? this.point(list.slice(k, k + 2)) : []));
    return { t: now, points: mapped, radius: radius * Math.sqrt(this.scale[0] * this.scale[1]) };
  }

  /** Returns the region in the other result; empty if that lacks the frame. */
  region(t: number, region: Region): [number, Region][] {
    const now = this.frame(t);
    if (now === null) return [];
    const { width, height } = this.size;
    if (width === this.old.width && height === this.old.height) return [[now, region]];
    const mapped = resizeLabels(decodeRuns(region), this.old, this.size);
    return mapped.includes(1) ? [[now, encodeRuns(mapped)]] : [];
  }
}

/** Returns the index in `to` of the same frame of the clip. */
function mapFrame(t: number, trim: Trim, to: ClipJob): number | null {
  const frame = (trim.start + t * trim.step - to.trim.start) / to.trim.step;
  const isThere = Number.isInteger(frame) && frame >= 0 && frame < (to.corrections.masks?.numFrames ?? 0);
  return isThere ? frame : null;
}

/** Resizes labels by nearest neighbour. */
function resizeLabels(
  pixels: Uint8Array,
  from: { width: number; height: number },
  to: { width: number; height: number },
): Uint8Array {
  if (from.width === to.width && from.height === to.height) return pixels;
  const columns = Uint32Array.from({ length: to.width }, (_, x) => Math.floor(((x + 0.5) * from.width) / to.width));
  const result = new Uint8Array(to.width * to.height);
  for (let y = 0; y < to.height; y++) {
    const row = Math.floor(((y + 0.5) * from.height) / to.height) * from.width;
    for (let x = 0; x < to.width; x++) result[y * to.width + x] = pixels[row + columns[x]];
  }
  return result;
}

async function matchObjects(old: MaskSource, from: ClipJob, to: ClipJob): Promise<ObjectMatch> {
  const now = to.corrections.masks!;
  const counts = new Float64Array(256 * 256);
  let until = performance.now() + SLICE_MS;
  for (let t = 0; t < old.numFrames; t++) {
    const at = mapFrame(t, from.trim, to);
    if (at === null) continue;
    const [before, after] = [resizeLabels(old.labels(t), old, now), now.labels(at)];
    for (let p = 0; p < after.length; p++) counts[256 * before[p] + after[p]] += 1;
    if (performance.now() < until) continue;
    await yieldThread();
    until = performance.now() + SLICE_MS;
  }
  return new ObjectMatch(counts);
}

class ObjectMatch {
  before = new Float64Array(256);
  after = new Float64Array(256);

  /** @param counts pixels by label in the old and in the new result */
  constructor(readonly counts: Float64Array) {
    counts.forEach((count, k) => {
      this.before[k >> 8] += count;
      this.after[k & 255] += count;
    });
  }

  isThere(label: number) {
    return this.before[label] > 0;
  }

  /** @returns the label of the best match; null if none overlaps enough */
  newLabelOf(label: number): number | null {
    if (label === 0) return 0;
    let [best, most] = [0, 0];
    for (let now = 1; now < 256; now++) {
      const both = this.counts[256 * label + now];
      const share = both > 0 ? both / (this.before[label] + this.after[now] - both) : 0;
      if (share > most) [best, most] = [now, share];
    }
    return most >= MIN_OVERLAP ? best : null;
  }

  isWithin(label: number, now: number): boolean {
    return this.counts[256 * label + now] >= MIN_OVERLAP * this.before[label];
  }
}

function describeEdit(edit: Edit): string {
  if (edit.kind === 'merge') return describeJoin(edit.into, edit.others);
  if (edit.kind === 'split') {
    if (edit.label > 0) return `splitting ${objectName(edit.label)}`;
    return edit.at ? `the object added in frame ${edit.at.t + 1}` : 'a new object';
  }
  if (edit.kind === 'interpolate') return `masks from beside frames ${edit.from + 1} to ${edit.to}`;
  if (edit.kind !== 'paint') {
    const frame = (edit.strokes[0]?.t ?? 0) + 1;
    return edit.kind === 'apart' ? `split strokes in frame ${frame}` : `join strokes in frame ${frame}`;
  }
  const [{ label, parts }] = edit.paints;
  const frame = Number([...parts.keys()][0]) + 1;
  return label === 0 ? `erasing in frame ${frame}` : `painting in frame ${frame}`;
}

function describeJoin(into: number, others: readonly number[]) {
  const names = (into > 0 ? [into, ...others] : others).map(objectName).join(', ');
  return into > 0 ? `joining ${names}` : `making ${names} background`;
}
