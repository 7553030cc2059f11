/**
 * Corrections of a run, made again in the result of another run of the clip, as far as they still apply: each goes to
 * the objects that overlap most those that were meant. Fetched when a corrected result is run again.
 * @module
 */

import { decodeRuns, encodeRuns } from './library.js';
import { objectName } from './palette.js';
import { turn } from './stage-clock.js';

/** @typedef {import('./library.js').MaskEditor} MaskEditor */
/** @typedef {import('./library.js').MaskSource} MaskSource */
/** @typedef {import('./library.js').Edit} Edit */
/** @typedef {import('./library.js').Region} Region */
/** @typedef {import('./library.js').Stroke} Stroke */
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
  for (const edit of corrections.edits) {
    const applies = await remake(edit, corrections.before(edit), job, to).catch(() => false);
    if (!applies) lost.push(wordsOf(edit));
  }
  to.corrections.carried = to.corrections.edits.length;
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
 * @param {Edit} edit
 * @param {MaskEditor} old masks that it was made in
 * @param {ClipJob} from
 * @param {ClipJob} to
 * @returns {Promise<boolean>} whether it applies; it is made then
 */
async function remake(edit, old, from, to) {
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
  await corrections[edit.kind](/** @type {Stroke[]} */ (strokes));
  return true;
}

/**
 * @param {import('./corrections.js').Corrections} corrections
 * @param {Match} match
 * @param {number} into
 * @param {readonly number[]} others
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
 * @param {Edit} edit
 * @param {ClipJob} to
 * @param {Match} match
 * @param {Placed} placed
 */
async function repaint({ paints: [{ label, over, parts }] }, to, match, placed) {
  const { corrections } = to;
  const isNew = label > 0 && !match.isThere(label);
  const now = isNew ? corrections.newLabel() : match.of(label);
  const upon = over?.map((one) => match.of(one));
  const there = [...parts].flatMap(([t, { region }]) => placed.region(t, region));
  if (now === null || upon?.includes(null) || there.length === 0) return false;
  const [[t, region], ...others] = there;
  const painted = await corrections.paint({
    ...{ label: now, t, region },
    ...(upon ? { over: /** @type {number[]} */ (upon) } : {}),
  });
  if (isWhole(there)) for (const [at, one] of others) corrections.opened.extend(painted.edit, at, one, 1);
  // It is not in all frames between.
  else await corrections.carry(painted, new AbortController().signal, () => {});
  return true;
}

/** @param {[number, Region][]} parts */
function isWhole(parts) {
  const frames = parts.map(([t]) => t);
  return Math.max(...frames) - Math.min(...frames) === frames.length - 1;
}

/** @param {Uint32Array} counts of each label @returns {number} the one with most */
function mostOf(counts) {
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
    const list = Array.from(points);
    const moved = list.flatMap((_, k) => (k % 2 === 0 ? this.point(list.slice(k, k + 2)) : []));
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
    const moved = resized(decodeRuns(region), this.old, this.size);
    return moved.includes(1) ? [[now, encodeRuns(moved)]] : [];
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
 * @param {Edit} edit
 * @returns {string} for a list of what no longer applies
 */
function wordsOf(edit) {
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

/**
 * @param {number} into
 * @param {readonly number[]} others
 */
function joinWords(into, others) {
  const names = (into > 0 ? [into, ...others] : others).map(objectName).join(', ');
  return into > 0 ? `joining ${names}` : `making ${names} background`;
}
