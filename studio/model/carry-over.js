/**
 * Corrections of a run, made again in the result of another run of the clip, as far as they still apply: each goes to
 * the objects that overlap most those that were meant. Fetched when a corrected result is run again.
 * @module
 */

import { editMasks, regionOf, strokeRegion } from './library.js';
import { objectName } from './palette.js';
import { turn } from './stage-clock.js';

/** @typedef {import('./library.js').MaskSource} MaskSource */
/** @typedef {import('./library.js').Edit} Edit */
/** @typedef {import('./library.js').Region} Region */
/** @typedef {import('./corrections.js').Stroke} Stroke */
/** @typedef {import('./corrections.js').What} What */
/** @typedef {import('./corrections.js').Was} Was */
/** @typedef {import('./clip-job.js').ClipJob} ClipJob */
/** @typedef {import('./source.js').Take} Take */

/** Objects are one where so much of what both cover is covered by each. */
const LEAST_OVERLAP = 0.5;

/** So long it is worked before others get their turn, in milliseconds. */
const SLICE_MS = 12;

/**
 * @param {{job: ClipJob, hidden: ReadonlySet<number>}} from a result, and its objects that are not kept
 * @param {ClipJob} to another result, without corrections; gets them
 * @returns {Promise<{hidden: Set<number>, lost: string[]}>} the objects of the new result that are not kept, and what no
 *   longer applies
 */
export async function carryOver({ job, hidden }, to) {
  const { corrections } = job;
  /** @type {string[]} */
  const lost = job.holdsOthers ? ['what was corrected before the clip was opened again'] : [];
  for (const { what, was } of corrections.done) {
    const applies = was && (await remake(what, maskedAs(was, corrections), job, to).catch(() => false));
    if (!applies) lost.push(wordsOf(what));
  }
  to.corrections.carried = to.corrections.done.length;
  to.presence = null;
  /** @type {Set<number>} */
  const left = new Set();
  const last = corrections.masks;
  const match = hidden.size > 0 && last ? await matchOf(last, job, to).catch(() => null) : null;
  for (const object of hidden) {
    const now = object === 0 ? 0 : (match?.of(object) ?? null);
    if (now !== null) left.add(now);
    else if (match?.isThere(object)) lost.push(`leaving out ${objectName(object)}`);
  }
  return { hidden: left, lost };
}

/**
 * Masks as they were before a correction.
 *
 * @param {Was} was
 * @param {import('./corrections.js').Corrections} corrections
 * @returns {MaskSource}
 */
function maskedAs({ masks, edits }, { editor }) {
  if (!editor || edits === 0) return masks;
  const { width, height, numFrames } = masks;
  const before = editMasks({ width, height, numFrames, labels: (t) => masks.labels(t) });
  const all = editor.toJSON();
  before.restore({ ...all, edits: all.edits.slice(0, edits) });
  return before;
}

/**
 * @param {What} what
 * @param {MaskSource} old masks that it was made in
 * @param {ClipJob} from
 * @param {ClipJob} to
 * @returns {Promise<boolean>} whether it applies; it is made then
 */
async function remake(what, old, from, to) {
  const { corrections } = to;
  const match = await matchOf(old, from, to);
  const placed = new Placed(old, from.take, to);
  if (what.ask === 'join') return join(corrections, match, what.into, what.others);
  if (what.ask === 'split') {
    const label = match.of(what.label);
    const at = what.at && placed.at(what.at);
    if (label === null || at === null) return false;
    await corrections.split(label, at);
    return true;
  }
  if (what.ask === 'edits') return remakeEdits(what.edits, to, match, placed);
  const strokes = what.strokes.map((stroke) => placed.stroke(stroke));
  const meant = what.strokes.map((stroke) => match.of(labelUnder(old, stroke)));
  if (meant.includes(null) || strokes.includes(null)) return false;
  await corrections[what.ask](/** @type {Stroke[]} */ (strokes));
  return true;
}

/**
 * @param {import('./corrections.js').Corrections} corrections
 * @param {Match} match
 * @param {number} into
 * @param {number[]} others
 */
async function join(corrections, match, into, others) {
  const found = match.of(into);
  if (found === null) return false;
  const now = others.map((one) => match.of(one));
  const joined = [...new Set(now)].filter((one) => one !== null && one !== found);
  if (joined.length > 0) await corrections.join(found, /** @type {number[]} */ (joined));
  // What is part of it already needs nothing.
  return others.every((one, k) => now[k] !== null || match.isWithin(one, found));
}

/**
 * @param {Edit[]} edits one step
 * @param {ClipJob} to
 * @param {Match} match
 * @param {Placed} placed
 */
async function remakeEdits(edits, to, match, placed) {
  const { corrections } = to;
  const [first] = edits;
  if (first?.table) {
    const [[, into]] = Object.entries(first.table);
    return join(corrections, match, into, Object.keys(first.table).map(Number));
  }
  const painted = edits.map((edit) => paintedAs(edit, match, placed));
  if (painted.length === 0 || painted.includes(null)) return false;
  /** @type {{edit: Edit, frames: number[]}[]} Those that are not in all frames between. */
  const open = [];
  await corrections.edited((editor) => {
    return /** @type {NonNullable<typeof painted[number]>[]} */ (painted).map(({ label, over, parts }) => {
      const [[t, region], ...others] = parts;
      const edit = editor.paint({ label: label ?? editor.newLabel(), over, t, region });
      if (isWhole(parts)) for (const [at, one] of others) editor.extend(edit, at, one, 1);
      else open.push({ edit, frames: [t] });
      return edit;
    });
  }, null);
  for (const one of open) await corrections.carry(one, new AbortController().signal, () => {});
  return true;
}

/**
 * @param {Edit} edit
 * @param {Match} match
 * @param {Placed} placed
 * @returns {{label: number | null, over: number[] | undefined, parts: [number, Region][]} | null} null for a new label
 */
function paintedAs(edit, match, placed) {
  if (!edit.parts) return null;
  const { label, over, parts } = edit;
  const isNew = label > 0 && !match.isThere(label);
  const now = isNew ? null : match.of(label);
  const upon = over?.map((one) => match.of(one));
  const there = [...parts].flatMap(([t, { region }]) => placed.region(t, region));
  if ((now === null && !isNew) || upon?.includes(null) || there.length === 0) return null;
  return { label: now, over: /** @type {number[] | undefined} */ (upon ?? undefined), parts: there };
}

/** @param {[number, Region][]} parts */
function isWhole(parts) {
  const frames = parts.map(([t]) => t);
  return Math.max(...frames) - Math.min(...frames) === frames.length - 1;
}

/**
 * The label that a stroke lies on most.
 *
 * @param {MaskSource} masks
 * @param {Stroke} stroke
 */
function labelUnder(masks, stroke) {
  const labels = masks.labels(stroke.t);
  const region = strokeRegion(stroke, masks.width, masks.height);
  const counts = new Uint32Array(256);
  for (let k = 0; k < region.length; k += 2)
    for (let p = region[k]; p < region[k] + region[k + 1]; p++) counts[labels[p]] += 1;
  return counts.indexOf(Math.max(...counts));
}

/** Places of one result in another, which may be of another size and of other frames. */
class Placed {
  /**
   * @param {{width: number, height: number}} old
   * @param {Take} take
   * @param {ClipJob} to
   */
  constructor(old, take, to) {
    const { width, height } = /** @type {MaskSource} */ (to.corrections.masks);
    this.old = old;
    this.size = { width, height };
    this.scale = [width / old.width, height / old.height];
    this.frame = (/** @type {number} */ t) => frameIn(t, take, to);
  }

  /**
   * @param {{t: number, x: number, y: number}} place
   * @returns {{t: number, x: number, y: number} | null}
   */
  at({ t, x, y }) {
    const now = this.frame(t);
    const [px, py] = this.point([x, y]);
    return now === null ? null : { t: now, x: px, y: py };
  }

  /**
   * @param {ArrayLike<number>} place
   * @returns {[number, number]}
   */
  point({ 0: x, 1: y }) {
    const [sx, sy] = this.scale;
    return [(x + 0.5) * sx - 0.5, (y + 0.5) * sy - 0.5];
  }

  /**
   * @param {Stroke} stroke
   * @returns {Stroke | null}
   */
  stroke({ t, points, radius }) {
    const now = this.frame(t);
    if (now === null) return null;
    const moved = points.flatMap((_, k) => (k % 2 === 0 ? this.point(points.slice(k, k + 2)) : []));
    return { t: now, points: moved, radius: radius * Math.sqrt(this.scale[0] * this.scale[1]) };
  }

  /**
   * @param {number} t
   * @param {Region} region
   * @returns {[number, Region][]} none where that frame is not part of the other result
   */
  region(t, region) {
    const now = this.frame(t);
    if (now === null) return [];
    const { width, height } = this.size;
    if (width === this.old.width && height === this.old.height) return [[now, region]];
    const pixels = new Uint8Array(this.old.width * this.old.height);
    for (let k = 0; k < region.length; k += 2) pixels.fill(1, region[k], region[k] + region[k + 1]);
    const moved = regionOf(resized(pixels, this.old, this.size));
    return moved.length > 0 ? [[now, moved]] : [];
  }
}

/**
 * @param {number} t
 * @param {Take} take
 * @param {ClipJob} to
 * @returns {number | null} the same frame of the clip
 */
function frameIn(t, take, to) {
  const now = (take.start + t * take.step - to.take.start) / to.take.step;
  const isThere = Number.isInteger(now) && now >= 0 && now < (to.corrections.masks?.numFrames ?? 0);
  return isThere ? now : null;
}

/**
 * @param {Uint8Array} pixels
 * @param {{width: number, height: number}} from
 * @param {{width: number, height: number}} to
 * @returns {Uint8Array} at that size, each as the nearest
 */
function resized(pixels, from, to) {
  if (from.width === to.width && from.height === to.height) return pixels;
  const columns = Uint32Array.from({ length: to.width }, (_, x) => Math.floor(((x + 0.5) * from.width) / to.width));
  const result = new Uint8Array(to.width * to.height);
  for (let y = 0; y < to.height; y++) {
    const row = Math.floor(((y + 0.5) * from.height) / to.height) * from.width;
    for (let x = 0; x < to.width; x++) result[y * to.width + x] = pixels[row + columns[x]];
  }
  return result;
}

/**
 * @param {MaskSource} old
 * @param {ClipJob} from
 * @param {ClipJob} to
 * @returns {Promise<Match>} which objects of `to`, as it is now, those of `old` are
 */
async function matchOf(old, from, to) {
  const now = /** @type {MaskSource} */ (to.corrections.masks);
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
  /** @param {Float64Array} counts pixels with each label of the one and each of the other */
  constructor(counts) {
    this.counts = counts;
    this.before = new Float64Array(256);
    this.after = new Float64Array(256);
    counts.forEach((count, k) => {
      this.before[k >> 8] += count;
      this.after[k & 255] += count;
    });
  }

  /** @param {number} label of the first result */
  isThere(label) {
    return this.before[label] > 0;
  }

  /**
   * @param {number} label of the first result
   * @returns {number | null} of the object that overlaps it most; null where none does enough
   */
  of(label) {
    if (label === 0) return 0;
    let [best, most] = [0, 0];
    for (let now = 1; now < 256; now++) {
      const both = this.counts[256 * label + now];
      const share = both > 0 ? both / (this.before[label] + this.after[now] - both) : 0;
      if (share > most) [best, most] = [now, share];
    }
    return most >= LEAST_OVERLAP ? best : null;
  }

  /**
   * @param {number} label of the first result
   * @param {number} now of the second
   * @returns {boolean} whether it is part of it
   */
  isWithin(label, now) {
    return this.counts[256 * label + now] >= LEAST_OVERLAP * this.before[label];
  }
}

/**
 * @param {What} what
 * @returns {string} for a list of what no longer applies
 */
function wordsOf(what) {
  if (what.ask === 'join') return joinWords(what.into, what.others);
  if (what.ask === 'split') {
    if (what.label > 0) return `splitting ${objectName(what.label)}`;
    return what.at ? `the object made in frame ${what.at.t + 1}` : 'a new object';
  }
  if (what.ask !== 'edits') {
    const frame = (what.strokes[0]?.t ?? 0) + 1;
    return what.ask === 'apart' ? `what is apart in frame ${frame}` : `what belongs together in frame ${frame}`;
  }
  const [edit] = what.edits;
  if (edit?.table) {
    const [[, into]] = Object.entries(edit.table);
    return joinWords(into, Object.keys(edit.table).map(Number));
  }
  const frame = ([...(edit?.parts?.keys() ?? [])][0] ?? 0) + 1;
  return edit?.label === 0 ? `what was wiped away in frame ${frame}` : `what was painted in frame ${frame}`;
}

/**
 * @param {number} into
 * @param {number[]} others
 */
function joinWords(into, others) {
  const names = (into > 0 ? [into, ...others] : others).map(objectName).join(', ');
  return into > 0 ? `joining ${names}` : `making ${names} background`;
}
