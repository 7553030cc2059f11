// Corrections of a run, made again in the result of another run of the clip, as far as they still apply: each goes to
// the objects that overlap most those that were meant. Fetched when a corrected result is run again.

import { decodeRuns, encodeRuns } from './library.js';
import { objectName } from './palette.js';
import { turn } from './stage-clock.js';
import type { ClipJob } from './clip-job.js';
import type { Corrections } from './corrections.js';
import type { Edit, MaskEditor, MaskSource, Region, Stroke } from './library.js';
import type { Take } from './source.js';

/** Objects are one where so much of what both cover is covered by each. */
const LEAST_OVERLAP = 0.5;

/** So long it is worked before others get their turn, in milliseconds. */
const SLICE_MS = 12;

/**
 * @param from a result, and its objects that are not kept
 * @param to another result, without corrections; gets them
 * @returns the objects of the new result that are not kept, and what no longer applies
 */
export async function carryOver(
  { job, hidden }: { job: ClipJob; hidden: ReadonlySet<number> },
  to: ClipJob,
): Promise<{ hidden: Set<number>; lost: string[] }> {
  const { corrections } = job;
  const lost: string[] = job.holdsOthers ? ['what was corrected before the clip was opened again'] : [];
  for (const edit of corrections.edits) {
    const applies = await remake(edit, corrections.before(edit), job, to).catch(() => false);
    if (!applies) lost.push(wordsOf(edit));
  }
  to.corrections.carried = to.corrections.edits.length;
  to.presence = null;
  const left = new Set<number>();
  const last = corrections.masks;
  const match = hidden.size > 0 && last ? await matchOf(last, job, to).catch(() => null) : null;
  for (const object of hidden) {
    const now = object === 0 ? 0 : (match?.of(object) ?? null);
    if (now !== null) left.add(now);
    else if (match?.isThere(object)) lost.push(`leaving out ${objectName(object)}`);
  }
  return { hidden: left, lost };
}

/** @returns whether it applies; it is made then */
async function remake(edit: Edit, old: MaskEditor, from: ClipJob, to: ClipJob): Promise<boolean> {
  const { corrections } = to;
  const match = await matchOf(old, from, to);
  const placed = new Placed(old, from.take, to);
  if (edit.kind === 'merge') return join(corrections, match, edit.into, edit.others);
  if (edit.kind === 'paint') return repaint(edit, to, match, placed);
  if (edit.kind === 'split') {
    const label = match.of(edit.label);
    const at = edit.at && placed.at(edit.at);
    if (label === null || at === null) return false;
    await corrections.split(label, at);
    return true;
  }
  const strokes = edit.strokes.map((stroke) => placed.stroke(stroke));
  const meant = await Promise.all(edit.strokes.map(async (stroke) => match.of(mostOf(await old.labelsUnder(stroke)))));
  if (meant.includes(null) || strokes.includes(null)) return false;
  await corrections[edit.kind](strokes as Stroke[]);
  return true;
}

async function join(corrections: Corrections, match: Match, into: number, others: readonly number[]) {
  const found = match.of(into);
  if (found === null) return false;
  const now = others.map((one) => match.of(one));
  const joined = [...new Set(now)].filter((one) => one !== null && one !== found);
  if (joined.length > 0) await corrections.join(found, joined as number[]);
  // What is part of it already needs nothing.
  return others.every((one, k) => now[k] !== null || match.isWithin(one, found));
}

async function repaint({ paints: [{ label, over, parts }] }: Edit, to: ClipJob, match: Match, placed: Placed) {
  const { corrections } = to;
  const isNew = label > 0 && !match.isThere(label);
  const now = isNew ? corrections.newLabel() : match.of(label);
  const upon = over?.map((one) => match.of(one));
  const there = [...parts].flatMap(([t, { region }]) => placed.region(t, region));
  if (now === null || upon?.includes(null) || there.length === 0) return false;
  const [[t, region], ...others] = there;
  const painted = await corrections.paint({
    ...{ label: now, t, region },
    ...(upon ? { over: upon as number[] } : {}),
  });
  if (isWhole(there)) for (const [at, one] of others) corrections.opened.extend(painted.edit, at, one, 1);
  // It is not in all frames between.
  else await corrections.carry(painted, new AbortController().signal, () => {});
  return true;
}

function isWhole(parts: [number, Region][]) {
  const frames = parts.map(([t]) => t);
  return Math.max(...frames) - Math.min(...frames) === frames.length - 1;
}

function mostOf(counts: Uint32Array): number {
  return counts.indexOf(Math.max(...counts));
}

/** Places of one result in another, which may be of another size and of other frames. */
class Placed {
  size: { width: number; height: number };
  scale: number[];
  frame: (t: number) => number | null;

  constructor(
    readonly old: { width: number; height: number },
    take: Take,
    to: ClipJob,
  ) {
    const { width, height } = to.corrections.masks!;
    this.size = { width, height };
    this.scale = [width / old.width, height / old.height];
    this.frame = (t: number) => frameIn(t, take, to);
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
    const moved = list.flatMap((_, k) => (k % 2 === 0 ? this.point(list.slice(k, k + 2)) : []));
    return { t: now, points: moved, radius: radius * Math.sqrt(this.scale[0] * this.scale[1]) };
  }

  /** Returns the region in the other result; none where it does not have that frame. */
  region(t: number, region: Region): [number, Region][] {
    const now = this.frame(t);
    if (now === null) return [];
    const { width, height } = this.size;
    if (width === this.old.width && height === this.old.height) return [[now, region]];
    const moved = resized(decodeRuns(region), this.old, this.size);
    return moved.includes(1) ? [[now, encodeRuns(moved)]] : [];
  }
}

/** Returns the frame of `to` that is the same frame of the clip. */
function frameIn(t: number, take: Take, to: ClipJob): number | null {
  const now = (take.start + t * take.step - to.take.start) / to.take.step;
  const isThere = Number.isInteger(now) && now >= 0 && now < (to.corrections.masks?.numFrames ?? 0);
  return isThere ? now : null;
}

/** Resizes labels by the nearest neighbour. */
function resized(
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

/** Matches the objects of `old` with those of `to`. */
async function matchOf(old: MaskSource, from: ClipJob, to: ClipJob): Promise<Match> {
  const now = to.corrections.masks!;
  const counts = new Float64Array(256 * 256);
  let until = performance.now() + SLICE_MS;
  for (let t = 0; t < old.numFrames; t++) {
    const at = frameIn(t, from.take, to);
    if (at === null) continue;
    const [before, after] = [resized(old.labels(t), old, now), now.labels(at)];
    for (let p = 0; p < after.length; p++) counts[256 * before[p] + after[p]] += 1;
    if (performance.now() < until) continue;
    await turn();
    until = performance.now() + SLICE_MS;
  }
  return new Match(counts);
}

/** How objects of two results overlap, over all frames that both have. */
class Match {
  before = new Float64Array(256);
  after = new Float64Array(256);

  /** @param counts pixels with each label of the one and each of the other */
  constructor(readonly counts: Float64Array) {
    counts.forEach((count, k) => {
      this.before[k >> 8] += count;
      this.after[k & 255] += count;
    });
  }

  isThere(label: number) {
    return this.before[label] > 0;
  }

  /** @returns of the object that overlaps it most; null where none does enough */
  of(label: number): number | null {
    if (label === 0) return 0;
    let [best, most] = [0, 0];
    for (let now = 1; now < 256; now++) {
      const both = this.counts[256 * label + now];
      const share = both > 0 ? both / (this.before[label] + this.after[now] - both) : 0;
      if (share > most) [best, most] = [now, share];
    }
    return most >= LEAST_OVERLAP ? best : null;
  }

  isWithin(label: number, now: number): boolean {
    return this.counts[256 * label + now] >= LEAST_OVERLAP * this.before[label];
  }
}

function wordsOf(edit: Edit): string {
  if (edit.kind === 'merge') return joinWords(edit.into, edit.others);
  if (edit.kind === 'split') {
    if (edit.label > 0) return `splitting ${objectName(edit.label)}`;
    return edit.at ? `the object made in frame ${edit.at.t + 1}` : 'a new object';
  }
  if (edit.kind !== 'paint') {
    const frame = (edit.strokes[0]?.t ?? 0) + 1;
    return edit.kind === 'apart' ? `what is apart in frame ${frame}` : `what belongs together in frame ${frame}`;
  }
  const [{ label, parts }] = edit.paints;
  const frame = Number([...parts.keys()][0]) + 1;
  return label === 0 ? `what was wiped away in frame ${frame}` : `what was painted in frame ${frame}`;
}

function joinWords(into: number, others: readonly number[]) {
  const names = (into > 0 ? [into, ...others] : others).map(objectName).join(', ');
  return into > 0 ? `joining ${names}` : `making ${names} background`;
}
