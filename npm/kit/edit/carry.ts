// Carries an edit of one frame to the frames before and after it, as long as flow and colours support the pixels that it
// changes.
//
// Each pixel of the next frame is traced back along the optical flow. It belongs to the region if it comes from the region,
// passes the forward-backward check, and looks more like the painted side than like the other side, in the painted frame
// around its origin. The colours around it in the present frame can only reject it: the masks there may have the error that
// is corrected. Scores are averaged over pixels of similar colour. Regions do not grow, so an edit never changes pixels that
// are not joined to the painted ones through time.

import { TraceCutError, checkNumber, checkWholeNumber, illegal } from '../../check/errors.js';
import { findShot } from '../../check/masks.js';
import { decodeRuns, encodeRuns } from '../../session/serialize.js';
import { type ImageEngine, createImageEngine } from '../../stages/image.js';
import type { FlowField } from '../../session/engine.js';
import { type Picture, type Size, checkPicture, createPlaces, findPixel, readColours, readFlow } from './motion.js';
import type { Edit, MaskEditor, Paint, Part } from './editor.js';

/** Limits on carrying an edit. */
export interface CarryOptions {
  /** First frame that it may reach; the first of the shot, or of the clip, if not given. */
  first?: number;
  /** Last frame that it may reach; the last of the shot, or of the clip, if not given. */
  last?: number;
  /** Least evidence for the pixels that it changes in a frame, 0 to 1; .75 if not given, and 0 goes on until nothing is left. */
  minEvidence?: number;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
  /** Called for each frame that was reached. */
  onFrame?: (reached: { t: number; evidence: number }) => void;
}

/** The first and the last frame that have the edit. */
export type CarryRange = { first: number; last: number };

// All chosen by their effect on clips (docs/results.md), of which the least evidence decides most.

/** Least evidence for the pixels that an edit changes in a frame. */
const DEFAULT_MIN_EVIDENCE = 0.75;
/** How far around a region pixels are followed: they hold its border against smoothing. */
const BAND_PX = 4;
/** Radius in which colours are compared, in the painted frame and in the present one. */
const PAINTED_RADIUS_PX = 8;
const PRESENT_RADIUS_PX = 12;
/** Difference of colours, the mean of red, green and blue of 255, by which evidence grows by 1. */
const COLOUR_SCALE = 8;
/** Largest evidence of colours; the evidence of a place is at most 1. */
const MAX_COLOUR_EVIDENCE = 2;
/** Largest difference from the colours of the painted side; pixels beyond it are outside. */
const MAX_COLOUR_DIFFERENCE = 30;
/** Radius in which pixels of similar colour decide together. */
const SMOOTHING_RADIUS_PX = 2;
/** Least share of its area that a region keeps from one frame to the next, */
const MIN_KEPT_AREA = 0.5;
/** and of the painted area; with less it is lost. */
const MIN_AREA_SHARE = 0.25;

/** Carries the regions that an edit paints to the frames before and after it, as parts of the same edit. */
export async function carry(
  editor: MaskEditor,
  edit: Edit,
  options: CarryOptions & { picture: (t: number) => Picture | Promise<Picture> },
  openEngine: (() => Promise<ImageEngine>) | undefined,
): Promise<CarryRange> {
  const settings = checkCarry(editor, edit, options);
  const engine = await (openEngine ?? createImageEngine)();
  const range = { first: settings.start, last: settings.start };
  try {
    for (const paint of edit.paints) {
      const sides = [1, -1].map((step) => followRegion(edit, paint, step, settings, editor, engine));
      // Outward: one frame on each side in turn.
      while (sides.length > 0) {
        const side = sides.shift()!;
        const { value, done } = await side.next();
        if (done) continue;
        const { t, region, evidence } = value;
        sides.push(side);
        editor.extend(edit, t, region, evidence, paint);
        range.first = Math.min(range.first, t);
        range.last = Math.max(range.last, t);
        settings.onFrame?.({ t, evidence });
      }
    }
  } finally {
    if (!openEngine) engine.close();
  }
  return range;
}

/**
 * Yields the region of a painted area in the frames on one side of it, in order.
 * @param step 1 or -1
 */
async function* followRegion(
  edit: Edit,
  paint: Paint,
  step: number,
  { start, picture, first, last, minEvidence, signal }: ReturnType<typeof checkCarry>,
  editor: MaskEditor,
  engine: ImageEngine,
) {
  const { label, over } = paint;
  const pixels = decodeRuns(paint.parts.get(start)!.region);
  const paintedArea = countInside(pixels);
  let before = checkPicture(await picture(start), start);
  const painted = readSide(before, editor.labels(start), label, editor);
  let region: FollowedRegion = { pixels, ...createPlaces(editor) };
  for (let t = start + step; t >= first && t <= last; t += step) {
    signal?.throwIfAborted();
    const now = checkPicture(await picture(t), t);
    const [back, forth] = [await engine.flow(now, before), await engine.flow(before, now)];
    signal?.throwIfAborted();
    const labels = editor.labels(t, edit);
    const isChanged = labels.map((found) => Number(found !== label && (!over || over.includes(found))));
    const present = readSide(now, labels, label, editor);
    const next = moveRegion(region, { back, forth }, { painted, present, isChanged });
    const area = countInside(next.pixels);
    const isLost = area < MIN_KEPT_AREA * countInside(region.pixels) || area < MIN_AREA_SHARE * paintedArea;
    const evidence = isLost ? 0 : next.evidence;
    if (evidence < minEvidence || area === 0) return;
    region = next;
    yield { t, region: encodeRuns(next.pixels), evidence };
    before = now;
  }
}

function checkCarry(
  editor: MaskEditor,
  edit: Edit,
  options: CarryOptions & { picture: (t: number) => Picture | Promise<Picture> },
) {
  const start = [...(edit?.paints?.[0]?.parts.keys() ?? [])][0];
  if (start === undefined) throw illegal('param', 'edit', edit, 'an edit that paints');
  if (!editor.edits.includes(edit)) throw new TraceCutError('state', 'only a painted edit in force can be carried');
  // Beyond a cut there is another scene.
  const shot = findShot(editor, start);
  const { picture, first = shot.first, last = shot.last } = options;
  const { minEvidence = DEFAULT_MIN_EVIDENCE } = options;
  checkWholeNumber('param', 'first', first, 0, start);
  checkWholeNumber('param', 'last', last, start, editor.numFrames - 1);
  checkNumber('minEvidence', minEvidence, 0, 1);
  return { start, picture, first, last, minEvidence, signal: options.signal, onFrame: options.onFrame };
}

/** A region in a frame, and for the pixels in and around it the place in the painted frame that they come from. */
type FollowedRegion = { pixels: Uint8Array; x: Float32Array; y: Float32Array };

/** A frame at the size of the masks: its colours, and 1 for the pixels that have the painted label. */
type Side = Size & { colours: Float32Array; isInside: Uint8Array };

/** What pixels of a frame are compared with, and 1 for those that the edit would change. */
type Comparison = { painted: Side; present: Side; isChanged: Uint8Array };

/** @param labels of the frame */
function readSide(picture: Picture, labels: Uint8Array, label: number, { width, height }: Size): Side {
  const isInside = labels.map((found) => Number(found === label));
  return { width, height, colours: readColours(picture, { width, height }), isInside };
}

/**
 * Finds a region in the next frame.
 * @param flows `back` leads from the pixels of the next frame to this one, `forth` from this one to the next
 * @returns with the evidence for the pixels that the edit changes, 0 to 1; 1 if it changes none
 */
function moveRegion(
  region: FollowedRegion,
  flows: { back: FlowField; forth: FlowField },
  comparison: Comparison,
): FollowedRegion & { evidence: number } {
  const { present, isChanged } = comparison;
  const { followed, scores, isConsistent, ...origins } = scorePixels(region, flows, comparison);
  const pixels = new Uint8Array(scores.length);
  let [numChanged, evidence] = [0, 0];
  for (const p of followed) {
    const score = smoothScore(scores, present, p);
    if (score <= 0) continue;
    pixels[p] = 1;
    numChanged += Number(isChanged[p]);
    if (isChanged[p] && isConsistent[p]) evidence += 1 / (1 + Math.exp(-2 * score));
  }
  return { pixels, ...origins, evidence: numChanged === 0 ? 1 : evidence / numChanged };
}

/** Scores the pixels that come from a region or its surroundings: positive for those that belong to it, NaN for others. */
function scorePixels(
  region: FollowedRegion,
  { back, forth }: { back: FlowField; forth: FlowField },
  { painted, present }: Comparison,
) {
  const { width, height } = present;
  const near = dilate(region.pixels, present, BAND_PX);
  const [x, y] = [new Float32Array(width * height), new Float32Array(width * height)];
  const scores = new Float32Array(width * height).fill(NaN);
  const isConsistent = new Uint8Array(width * height);
  const followed: number[] = [];
  const isFollowed = new Uint8Array(width * height);
  for (let p = 0; p < width * height; p += 1) {
    const [column, row] = [p % width, Math.floor(p / width)];
    const [u, v] = readFlow(back, column, row, present);
    const [px, py] = [column + u, row + v];
    const q = findPixel(px, py, present);
    if (q < 0 || !near[q]) continue;
    followed.push(p);
    isFollowed[p] = 1;
    x[p] = Number(region.x[q]) + px - (q % width);
    y[p] = Number(region.y[q]) + py - Math.floor(q / width);
    const [forthU, forthV] = readFlow(forth, px, py, present);
    const error = (u + forthU) ** 2 + (v + forthV) ** 2;
    isConsistent[p] = Number(error <= 0.01 * (u * u + v * v + forthU * forthU + forthV * forthV) + 0.5);
    const place = 2 * sampleMask(region.pixels, present, px, py) - 1;
    scores[p] = Number(isConsistent[p]) * place;
    // Pixels outside of the region have no colours: it would grow into what looks alike.
    if (place <= 0) continue;
    const origin = { x: Number(x[p]), y: Number(y[p]), radius: PAINTED_RADIUS_PX };
    const { inside, outside } = findLeastDifferences(present, p, painted, origin);
    const colour = inside > MAX_COLOUR_DIFFERENCE ? -MAX_COLOUR_EVIDENCE : weighColours(inside, outside);
    scores[p] = Number(scores[p]) + colour;
  }
  for (const p of followed) {
    const here = { x: p % width, y: Math.floor(p / width), radius: PRESENT_RADIUS_PX };
    const { inside, outside } = findLeastDifferences(present, p, present, here, isFollowed);
    if (Number.isFinite(inside) && Number.isFinite(outside)) scores[p]! += Math.min(0, weighColours(inside, outside));
  }
  extrapolate(x, y, followed, present);
  return { followed, scores, isConsistent, x, y };
}

/** Gives pixels that were not followed the mean displacement of those that were. */
function extrapolate(x: Float32Array, y: Float32Array, followed: number[], { width, height }: Size) {
  const isKnown = new Uint8Array(width * height);
  let [dx, dy] = [0, 0];
  for (const p of followed) {
    isKnown[p] = 1;
    dx += (Number(x[p]) - (p % width)) / followed.length;
    dy += (Number(y[p]) - Math.floor(p / width)) / followed.length;
  }
  for (let p = 0; p < width * height; p += 1)
    if (!isKnown[p]) [x[p], y[p]] = [(p % width) + dx, Math.floor(p / width) + dy];
}

/** Returns the evidence of colours for the inside. */
function weighColours(inside: number, outside: number): number {
  const evidence = (outside - inside) / COLOUR_SCALE;
  return Math.max(-MAX_COLOUR_EVIDENCE, Math.min(MAX_COLOUR_EVIDENCE, evidence));
}

/**
 * Returns the differences of a pixel's colour to the most similar ones of both sides around a place, the mean of three;
 * infinite for a side with fewer.
 * @param isExcluded 1 for pixels that do not count
 */
function findLeastDifferences(
  from: Side,
  p: number,
  to: Side,
  { x, y, radius }: { x: number; y: number; radius: number },
  isExcluded?: Uint8Array,
): { inside: number; outside: number } {
  const inside: LeastThree = [Infinity, Infinity, Infinity];
  const outside: LeastThree = [Infinity, Infinity, Infinity];
  const [column, row] = [Math.round(x), Math.round(y)];
  for (let j = Math.max(0, row - radius); j <= Math.min(to.height - 1, row + radius); j += 1) {
    for (let i = Math.max(0, column - radius); i <= Math.min(to.width - 1, column + radius); i += 1) {
      const q = j * to.width + i;
      if (!isExcluded?.[q]) insert(to.isInside[q] ? inside : outside, compareColours(from, p, to, q));
    }
  }
  const mean = ([a, b, c]: LeastThree) => (a + b + c) / 3;
  return { inside: mean(inside), outside: mean(outside) };
}

/** Three numbers, ascending. */
type LeastThree = [number, number, number];

/** Inserts a number among the least three. */
function insert(least: LeastThree, value: number) {
  if (value >= least[2]) return;
  least[2] = value;
  if (least[2] < least[1]) [least[1], least[2]] = [least[2], least[1]];
  if (least[1] < least[0]) [least[0], least[1]] = [least[1], least[0]];
}

/** Returns the mean score around a pixel, weighted by similarity of colour. */
function smoothScore(scores: Float32Array, frame: Side, p: number): number {
  const { width, height } = frame;
  const [x, y] = [p % width, Math.floor(p / width)];
  let [total, weights] = [0, 0];
  for (let j = Math.max(0, y - SMOOTHING_RADIUS_PX); j <= Math.min(height - 1, y + SMOOTHING_RADIUS_PX); j += 1) {
    for (let i = Math.max(0, x - SMOOTHING_RADIUS_PX); i <= Math.min(width - 1, x + SMOOTHING_RADIUS_PX); i += 1) {
      const q = j * width + i;
      if (Number.isNaN(scores[q])) continue;
      const weight = Math.exp(-compareColours(frame, p, frame, q) / COLOUR_SCALE);
      total += weight * Number(scores[q]);
      weights += weight;
    }
  }
  return total / weights;
}

/** Returns the mean difference of red, green and blue of two pixels. */
function compareColours({ colours: a }: Side, p: number, { colours: b }: Side, q: number): number {
  const [i, j] = [3 * p, 3 * q];
  return (Math.abs(a[i]! - b[j]!) + Math.abs(a[i + 1]! - b[j + 1]!) + Math.abs(a[i + 2]! - b[j + 2]!)) / 3;
}

/** Returns 1 for the pixels at most `radius` columns and rows from a pixel of the region. */
function dilate(pixels: Uint8Array, { width }: Size, radius: number): Uint8Array {
  const rows = new Uint8Array(pixels.length);
  pixels.forEach((inside, p) => {
    const start = p - (p % width);
    if (inside) rows.fill(1, Math.max(start, p - radius), Math.min(start + width, p + radius + 1));
  });
  const dilated = new Uint8Array(pixels.length);
  rows.forEach((inside, p) => {
    if (!inside) return;
    const last = Math.min(pixels.length - 1, p + radius * width);
    for (let q = Math.max(p % width, p - radius * width); q <= last; q += width) dilated[q] = 1;
  });
  return dilated;
}

function countInside(pixels: Uint8Array): number {
  return pixels.reduce((total, inside) => total + inside, 0);
}

/** Interpolates the mask at a place between pixels, 0 to 1; it is 0 beyond the frame. */
function sampleMask(pixels: Uint8Array, { width, height }: Size, x: number, y: number) {
  const [left, top] = [Math.floor(x), Math.floor(y)];
  if (left < -1 || top < -1 || left >= width || top >= height) return 0;
  const [ax, ay] = [x - left, y - top];
  const valueAt = (i: number, j: number) =>
    i >= 0 && j >= 0 && i < width && j < height ? Number(pixels[j * width + i]) : 0;
  const upper = (1 - ax) * valueAt(left, top) + ax * valueAt(left + 1, top);
  const lower = (1 - ax) * valueAt(left, top + 1) + ax * valueAt(left + 1, top + 1);
  return (1 - ay) * upper + ay * lower;
}
