// Proposals to join objects that look like pieces of one: they touch and move together, or one begins where and when the
// other ends.

import type { TrajectorySource } from './library.js';
import type { Store } from './store.js';

interface LabelledClip {
  width: number;
  height: number;
  numFrames: number;
  /** Returns the object of each pixel. */
  labels: (t: number) => ArrayLike<number>;
  trajectories: TrajectorySource['trajectories'];
  /** The first and the last frame of each object. */
  spans: readonly { object: number; first: number; last: number }[];
  /** First frames of further shots. */
  cuts: readonly number[];
  /** Position of the background in each frame. */
  scene: { x: ArrayLike<number>; y: ArrayLike<number> };
}

/** Largest number of sampled frames; chosen by eye. */
const MAX_FRAMES = 24;

/** Largest gap between touching objects, as a share of the long side; chosen by eye. */
const MAX_GAP_SHARE = 0.01;

/**
 * Largest difference of similar motions, as a share of the slower object's motion against the background; chosen by
 * eye.
 */
const MAX_MOTION_DIFFERENCE = 0.25;

/** Slowest motion against the background that is compared, in pixels per frame; chosen by eye. */
const MIN_SPEED_PX = 0.2;

/**
 * Smallest intersection over union of an object's first mask with the last mask of the one that it continues; chosen by
 * eye.
 */
const MIN_CONTINUED_OVERLAP = 0.5;

/** Summed motion of an object's trajectories. */
type MotionSum = { n: number; x: number; y: number };
type Pair = { frames: number; adjacentFrames: number; motionFrames: number; difference: number; a: number; b: number };

/** Returns groups of two or more similar objects, largest group first, largest object first. */
export function findSimilarObjects(clip: LabelledClip): number[][] {
  const { width, height, numFrames, labels, scene } = clip;
  const maxGap = Math.max(2, Math.round(MAX_GAP_SHARE * Math.max(width, height)));
  const pairs = new Map<number, Pair>();
  const sizes = new Map<number, number>();
  const step = Math.max(1, Math.ceil(numFrames / MAX_FRAMES));
  for (let t = 0; t < numFrames; t += step) {
    const mask = labels(t);
    const areas = countAreas(mask);
    for (const [object, area] of areas) sizes.set(object, (sizes.get(object) ?? 0) + area);
    const adjacent = findAdjacentPairs(mask, width, height, maxGap);
    const objectMotions = sumMotions(clip, mask, t);
    const background = { x: scene.x[t + 1] - scene.x[t], y: scene.y[t + 1] - scene.y[t] };
    for (const a of areas.keys())
      for (const b of areas.keys())
        if (a < b)
          addMotion(getOrAddPair(pairs, pairKey(a, b)), objectMotions.get(a), objectMotions.get(b), background);
    for (const key of adjacent) getOrAddPair(pairs, key).adjacentFrames += 1;
  }
  const links = [...pairs].filter(([, pair]) => movesTogether(pair)).map(([key]) => [key >> 8, key & 255]);
  return groupLinks([...links, ...findContinued(clip)], sizes);
}

/** Returns pairs of objects of which one ends before a frame, and the other begins in it at the same place. */
function findContinued({ labels, spans, cuts }: LabelledClip): number[][] {
  const objects = spans.filter(({ object, first }) => object > 0 && first >= 0);
  return objects.flatMap(({ object, first }) => {
    // Beyond a cut there is another scene.
    if (first === 0 || cuts.includes(first)) return [];
    const ended = objects.filter(({ last }) => last === first - 1);
    if (ended.length === 0) return [];
    const [before, after] = [labels(first - 1), labels(first)];
    return ended
      .filter((candidate) => overlapOf(before, candidate.object, after, object) >= MIN_CONTINUED_OVERLAP)
      .map((candidate) => [candidate.object, object]);
  });
}

/** Returns the intersection over union of an object in one mask and another in the next. */
function overlapOf(before: ArrayLike<number>, a: number, after: ArrayLike<number>, b: number): number {
  let [both, either] = [0, 0];
  for (let p = 0; p < before.length; p += 1) {
    const [inBefore, inAfter] = [before[p] === a, after[p] === b];
    both += Number(inBefore && inAfter);
    either += Number(inBefore || inAfter);
  }
  return both / Math.max(1, either);
}

function pairKey(a: number, b: number) {
  return (Math.min(a, b) << 8) | Math.max(a, b);
}

function getOrAddPair(pairs: Map<number, Pair>, key: number) {
  const pair = pairs.get(key) ?? { frames: 0, adjacentFrames: 0, motionFrames: 0, difference: 0, a: 0, b: 0 };
  pairs.set(key, pair);
  return pair;
}

function addMotion(
  pair: Pair,
  a: MotionSum | undefined,
  b: MotionSum | undefined,
  background: { x: number; y: number },
) {
  pair.frames += 1;
  if (!a || !b || Number.isNaN(background.x)) return;
  const square = (x: number, y: number) => x * x + y * y;
  const [aX, aY, bX, bY] = [a.x / a.n, a.y / a.n, b.x / b.n, b.y / b.n];
  pair.motionFrames += 1;
  pair.difference += square(aX - bX, aY - bY);
  pair.a += square(aX - background.x, aY - background.y);
  pair.b += square(bX - background.x, bY - background.y);
}

function movesTogether({ frames, adjacentFrames, motionFrames, difference, a, b }: Pair) {
  const slowest = Math.min(a, b);
  return (
    adjacentFrames > frames / 2 &&
    motionFrames > frames / 2 &&
    slowest > MIN_SPEED_PX ** 2 * motionFrames &&
    difference < MAX_MOTION_DIFFERENCE ** 2 * slowest
  );
}

function countAreas(mask: ArrayLike<number>) {
  const areas = new Uint32Array(256);
  for (let p = 0; p < mask.length; p += 1) areas[mask[p]] += 1;
  return new Map([...areas.entries()].filter(([object, area]) => object > 0 && area > 0));
}

/** @param maxGap in pixels, along a row or a column */
function findAdjacentPairs(mask: ArrayLike<number>, width: number, height: number, near: number): Set<number> {
  const pairs = new Set<number>();
  // The last object and its position, in the row and in each column.
  const row = { object: 0, at: 0 };
  const columns = Array.from({ length: width }, () => ({ object: 0, at: 0 }));
  const visit = (last: typeof row, object: number, at: number) => {
    if (last.object > 0 && last.object !== object && at - last.at <= near) pairs.add(pairKey(last.object, object));
    last.object = object;
    last.at = at;
  };
  for (let y = 0; y < height; y += 1) {
    row.object = 0;
    for (let x = 0; x < width; x += 1) {
      const object = mask[y * width + x];
      if (object === 0) continue;
      visit(row, object, x);
      visit(columns[x], object, y);
    }
  }
  return pairs;
}

/** Sums the motion of each object to the next frame. */
function sumMotions(
  { width, height, trajectories }: LabelledClip,
  mask: ArrayLike<number>,
  t: number,
): Map<number, MotionSum> {
  const { count, startFrame, offset, x, y } = trajectories;
  const sums = new Map<number, MotionSum>();
  for (let i = 0; i < count; i += 1) {
    const at = offset[i] + t - startFrame[i];
    if (at < offset[i] || at + 1 >= offset[i + 1]) continue;
    const [px, py] = [Math.round(x[at]), Math.round(y[at])];
    const object = px >= 0 && py >= 0 && px < width && py < height ? mask[py * width + px] : 0;
    if (object === 0) continue;
    const sum = sums.get(object) ?? { n: 0, x: 0, y: 0 };
    sums.set(object, { n: sum.n + 1, x: sum.x + x[at + 1] - x[at], y: sum.y + y[at + 1] - y[at] });
  }
  return sums;
}

function groupLinks(links: number[][], sizes: Map<number, number>) {
  const groupOf = new Map<number, Set<number>>();
  for (const [a, b] of links) {
    const group = new Set([...(groupOf.get(a) ?? [a]), ...(groupOf.get(b) ?? [b])]);
    for (const object of group) groupOf.set(object, group);
  }
  const bySize = (a: number, b: number) => (sizes.get(b) ?? 0) - (sizes.get(a) ?? 0);
  return [...new Set(groupOf.values())].map((group) => [...group].sort(bySize)).sort((a, b) => b.length - a.length);
}

/** Time without changes before similar objects are searched, in milliseconds; chosen by eye. */
const SEARCH_DELAY_MS = 200;

export class JoinProposals {
  groups: number[][] = [];
  /** Groups that the user does not want to join. */
  dismissed = new Set<string>();
  timer: ReturnType<typeof setTimeout> | undefined = undefined;

  /** @param onFound called after each search */
  constructor(
    readonly store: Store,
    readonly onFound: () => void,
  ) {
    store.watch(['visit'], () => this.dismissed.clear());
    store.watch(['analysis', 'phase'], () => this.searchSoon());
  }

  /** The objects to propose; undefined if there are none. */
  get current(): number[] | undefined {
    return this.groups.find((group) => !this.dismissed.has(String(group)));
  }

  dismiss() {
    this.dismissed.add(String(this.current));
  }

  searchSoon() {
    this.groups = [];
    clearTimeout(this.timer);
    const { analysis, phase, timeline, job } = this.store.state;
    const segmentation = analysis?.segmentation;
    if (phase !== 'done' || !segmentation || !job?.corrector) return;
    this.timer = setTimeout(() => {
      const { width, height, numFrames, trajectories } = segmentation.result;
      const labels = (t: number) => segmentation.mask(t)!;
      this.groups = findSimilarObjects({
        ...{ width, height, numFrames, trajectories, labels, scene: segmentation.scene },
        ...{ spans: analysis.facts, cuts: timeline.cuts },
      });
      this.onFound();
    }, SEARCH_DELAY_MS);
  }
}
