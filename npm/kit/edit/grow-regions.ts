// Finds the object at a place: regions of superpixels that grow from there, over weak borders first.

import { TraceCutError, checkWholeNumber, illegal } from '../../check/errors.js';
import { type Runs as Region, encodeRuns } from '../../session/serialize.js';
import type { FlowField } from '../../session/engine.js';
import type { Superpixels } from '../../stages/image.js';
import type { Picture } from './motion.js';

/** Features of a frame: its superpixels, its pixels, and its flow to a neighbouring frame, all of one size. */
export interface FrameFeatures {
  superpixels: Superpixels;
  picture: Picture;
  flow: FlowField;
}

// All weights and limits below are chosen by eye.

/** Distance of colours in red, green and blue, each of 255, from which they count as entirely different. */
const MAX_COLOUR_DISTANCE = 110;
/** Difference of motions from which they count as entirely different, in pixels a frame. */
const MAX_MOTION_DIFFERENCE_PX = 2;
/** Weight of colours along a border; its boundary probability and motion weigh 1. */
const COLOUR_WEIGHT = 0.15;
/** Weight of a superpixel's difference to the motion of the growing region. */
const REGION_MOTION_WEIGHT = 0.5;
/** Cost reduction of a superpixel whose whole border touches the region. */
const ENCLOSED_BONUS = 0.2;
/** Weight of a region's size in its score, times the fourth root of its share of the frame. */
const SIZE_WEIGHT = 0.2;
/** Largest region, as a share of the frame. */
const MAX_AREA_SHARE = 0.5;
/** Most regions that are returned, and the largest ratio of the areas of two of them. */
const MAX_REGIONS = 3;
const MAX_AREA_RATIO = 0.7;

type SuperpixelStats = { area: number; frameBorder: number; colour: number[]; motion: number[] };
type HasMotion = Pick<SuperpixelStats, 'motion'>;
type Link = { to: number; length: number; weight: number };

/**
 * Returns the regions that a click may mean, the likeliest first, at most three of clearly different sizes. A region
 * grows from the superpixel at the place by one superpixel after the other: over weak boundaries, to similar colours and
 * motion. The regions with the strongest borders on the way are returned.
 *
 * ```js
 * const features = { superpixels: await superpixels(now), flow: await flow(now, next), picture: now };
 * const [region] = await growRegions(features, { x: 120, y: 80 });
 * editor.paint({ label: editor.newLabel(), t, region });
 * ```
 * @param place in pixels, pixel centres at whole numbers
 */
export async function growRegions(
  { superpixels, picture, flow }: FrameFeatures,
  { x, y }: { x: number; y: number },
): Promise<Region[]> {
  const { label, width, height, count } = superpixels;
  for (const [name, input] of Object.entries({ picture, flow })) {
    if (input?.width !== width || input?.height !== height)
      throw illegal('data', name, `${input?.width} × ${input?.height}`, `${width} × ${height}, as the superpixels`);
  }
  if (picture.data?.length !== 4 * width * height)
    throw new TraceCutError('data', `picture.data has ${picture.data?.length} bytes (expected ${4 * width * height})`);
  const column = checkWholeNumber('param', 'x', Math.round(x), 0, width - 1);
  const row = checkWholeNumber('param', 'y', Math.round(y), 0, height - 1);
  const stats = measureSuperpixels(superpixels, picture, flow);
  const links = collectLinks(superpixels, stats);
  const seed = Number(label[row * width + column]);
  const { order, steps } = growFrom(seed, stats, links, width * height);
  const best: typeof steps = [];
  for (const step of [...steps].sort((a, b) => b.score - a.score)) {
    const isDistinct = best.every(({ area }) => Math.min(area, step.area) < MAX_AREA_RATIO * Math.max(area, step.area));
    if (isDistinct && best.length < MAX_REGIONS) best.push(step);
  }
  return best.map(({ taken }) => {
    const isIn = new Uint8Array(count);
    for (const piece of order.slice(0, taken)) isIn[piece] = 1;
    return encodeRuns(label.map((piece) => Number(isIn[piece])));
  });
}

function measureSuperpixels(
  { label, width, height, count }: FrameFeatures['superpixels'],
  { data }: FrameFeatures['picture'],
  { u, v }: FrameFeatures['flow'],
): SuperpixelStats[] {
  const stats = Array.from({ length: count }, () => ({ area: 0, frameBorder: 0, colour: [0, 0, 0], motion: [0, 0] }));
  for (let row = 0, p = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1, p += 1) {
      const piece = stats[Number(label[p])]!;
      piece.area += 1;
      piece.frameBorder += Number(column === 0 || row === 0 || column === width - 1 || row === height - 1);
      addTo(piece.colour, [data[4 * p], data[4 * p + 1], data[4 * p + 2]]);
      addTo(piece.motion, [u[p], v[p]]);
    }
  }
  for (const piece of stats) {
    piece.colour = piece.colour.map((sum) => sum / piece.area);
    piece.motion = piece.motion.map((sum) => sum / piece.area);
  }
  return stats;
}

/** Collects the borders of each superpixel. */
function collectLinks({ borders, count }: FrameFeatures['superpixels'], stats: SuperpixelStats[]): Link[][] {
  const links: Link[][] = Array.from({ length: count }, () => []);
  borders.a.forEach((a, k) => {
    const [b, length] = [Number(borders.b[k]), Number(borders.length[k])];
    const [first, second] = [stats[a]!, stats[b]!];
    const compareColours = Math.min(1, distance(first.colour, second.colour) / MAX_COLOUR_DISTANCE);
    const weight = Number(borders.pb[k]) + COLOUR_WEIGHT * compareColours + compareMotions(first, second);
    links[a]?.push({ to: b, length, weight });
    links[b]?.push({ to: a, length, weight });
  });
  return links;
}

/** Grows a region until it covers half of the frame; returns the superpixels in order, and the region after each. */
function growFrom(seed: number, stats: SuperpixelStats[], links: Link[][], pixels: number) {
  const region = { area: 0, frameBorder: 0, motion: [0, 0] };
  /** The region's border, without the frame border: its length, and the sum of weight times length. */
  const border = { length: 0, sum: 0 };
  /** Superpixels that touch the region, and their common border with it. */
  const neighbours = new Map<number, { length: number; sum: number }>();
  const borderLengths = links.map((list) => list.reduce((sum, { length }) => sum + length, 0));
  const members = new Set<number>();
  const steps = [];
  for (let next = seed; next >= 0; next = findCheapest(neighbours, region, stats, borderLengths)) {
    const piece = stats[next]!;
    members.add(next);
    neighbours.delete(next);
    const area = region.area + piece.area;
    region.motion = region.motion.map(
      (component, k) => (component * region.area + Number(piece.motion[k]) * piece.area) / area,
    );
    Object.assign(region, { area, frameBorder: region.frameBorder + piece.frameBorder });
    for (const { to, length, weight } of links[next] ?? []) {
      const sign = members.has(to) ? -1 : 1;
      border.length += sign * length;
      border.sum += sign * length * weight;
      if (sign < 0) continue;
      const before = neighbours.get(to) ?? { length: 0, sum: 0 };
      neighbours.set(to, { length: before.length + length, sum: before.sum + length * weight });
    }
    const strength = Math.max(0, border.sum) / Math.max(1, border.length + region.frameBorder);
    const score = strength + SIZE_WEIGHT * Math.sqrt(Math.sqrt(area / pixels));
    steps.push({ taken: members.size, area, score });
    if (area > MAX_AREA_SHARE * pixels) break;
  }
  return { order: [...members], steps };
}

/**
 * Returns the neighbour that costs least to add; -1 if there is none.
 * @param borderLengths length of all borders of each superpixel
 */
function findCheapest(
  neighbours: Map<number, { length: number; sum: number }>,
  region: HasMotion,
  stats: SuperpixelStats[],
  borderLengths: number[],
): number {
  let [best, least] = [-1, Infinity];
  for (const [to, { length, sum }] of neighbours) {
    const enclosed = Math.min(1, length / Math.max(1, Number(borderLengths[to])));
    const difference = compareMotions(stats[to]!, region);
    const cost = sum / length + REGION_MOTION_WEIGHT * difference - ENCLOSED_BONUS * enclosed;
    if (cost < least) [best, least] = [to, cost];
  }
  return best;
}

/** Returns the difference of two motions, 0 to 1. */
function compareMotions(a: HasMotion, b: HasMotion) {
  return Math.min(1, distance(a.motion, b.motion) / MAX_MOTION_DIFFERENCE_PX);
}

function distance(a: number[], b: number[]) {
  return Math.sqrt(a.reduce((sum, value, k) => sum + (value - Number(b[k])) ** 2, 0));
}

function addTo(sums: number[], values: (number | undefined)[]) {
  values.forEach((value, k) => (sums[k] = Number(sums[k]) + Number(value)));
}
