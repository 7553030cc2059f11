// The thing at a place: regions of superpixels that grow from there, over weak borders first.

import { TraceCutError, illegal, wholeNumber } from '../../check/errors.js';
import { type Runs as Region, encodeRuns } from '../../session/runs.js';
import type { FlowField } from '../../session/engine.js';
import type { Superpixels } from '../../stages/image.js';
import type { Picture } from './carry.js';

/** What a frame shows: its superpixels, its pixels, and its flow to a neighbouring frame, all of one size. */
export interface Grounds {
  superpixels: Superpixels;
  picture: Picture;
  flow: FlowField;
}

/** Colours that differ by as much or more are other ones, as a length in red, green and blue. */
const OTHER_COLOUR = 110;
/** Motions that differ by as much or more are other ones, in pixels a frame. */
const OTHER_MOTION = 2;
/** What colours weigh along a border; its boundary probability and motion weigh 1. */
const COLOUR_WEIGHT = 0.15;
/** What a motion other than the region's weighs when it grows. */
const REGION_WEIGHT = 0.5;
/** How much sooner a superpixel is taken that lies all within the region. */
const ENCLOSED = 0.2;
/** What the size of a region is worth, times the fourth root of its share of the frame. */
const SIZE_WEIGHT = 0.2;
/** Largest share of the frame. */
const MOST = 0.5;
/** Regions that are offered, and how alike their areas may be. */
const COUNT = 3;
const ALIKE = 0.7;

export type Piece = { area: number; rim: number; colour: number[]; motion: number[] };
export type Moving = Pick<Piece, 'motion'>;
export type Link = { to: number; length: number; weight: number };

/**
 * Regions that may be meant by a click, the likeliest first, at most three of clearly different sizes. A region grows from
 * the superpixel at the place by one superpixel after the other: over weak boundaries, to like colours and like motion.
 * Those on the way whose borders are strongest are given.
 *
 * ```js
 * const grounds = { superpixels: await superpixels(now), flow: await flow(now, next), picture: now };
 * const [region] = await grownRegions(grounds, { x: 120, y: 80 });
 * editor.paint({ label: editor.newLabel(), t, region });
 * ```
 * @param place in pixels, pixel centres at whole numbers
 */
export async function grownRegions(
  { superpixels, picture, flow }: Grounds,
  { x, y }: { x: number; y: number },
): Promise<Region[]> {
  const { label, width, height, count } = superpixels;
  for (const [name, other] of Object.entries({ picture, flow })) {
    if (other?.width !== width || other?.height !== height)
      throw illegal('data', name, `${other?.width} × ${other?.height}`, `${width} × ${height}, as the superpixels`);
  }
  if (picture.data?.length !== 4 * width * height)
    throw new TraceCutError('data', `picture.data has ${picture.data?.length} bytes (expected ${4 * width * height})`);
  const column = wholeNumber('param', 'x', Math.round(x), 0, width - 1);
  const row = wholeNumber('param', 'y', Math.round(y), 0, height - 1);
  const pieces = piecesOf(superpixels, picture, flow);
  const links = linksOf(superpixels, pieces);
  const seed = Number(label[row * width + column]);
  const { order, steps } = growth(seed, pieces, links, width * height);
  const best: typeof steps = [];
  for (const step of [...steps].sort((a, b) => b.score - a.score)) {
    const isOther = best.every(({ area }) => Math.min(area, step.area) < ALIKE * Math.max(area, step.area));
    if (isOther && best.length < COUNT) best.push(step);
  }
  return best.map(({ taken }) => {
    const isIn = new Uint8Array(count);
    for (const piece of order.slice(0, taken)) isIn[piece] = 1;
    return encodeRuns(label.map((piece) => Number(isIn[piece])));
  });
}

function piecesOf(
  { label, width, height, count }: Grounds['superpixels'],
  { data }: Grounds['picture'],
  { u, v }: Grounds['flow'],
): Piece[] {
  const pieces = Array.from({ length: count }, () => ({ area: 0, rim: 0, colour: [0, 0, 0], motion: [0, 0] }));
  for (let row = 0, p = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1, p += 1) {
      const piece = pieces[Number(label[p])]!;
      piece.area += 1;
      piece.rim += Number(column === 0 || row === 0 || column === width - 1 || row === height - 1);
      add(piece.colour, [data[4 * p], data[4 * p + 1], data[4 * p + 2]]);
      add(piece.motion, [u[p], v[p]]);
    }
  }
  for (const piece of pieces) {
    piece.colour = piece.colour.map((sum) => sum / piece.area);
    piece.motion = piece.motion.map((sum) => sum / piece.area);
  }
  return pieces;
}

/** The borders of each superpixel. */
function linksOf({ borders, count }: Grounds['superpixels'], pieces: Piece[]): Link[][] {
  const links: Link[][] = Array.from({ length: count }, () => []);
  borders.a.forEach((a, k) => {
    const [b, length] = [Number(borders.b[k]), Number(borders.length[k])];
    const [one, other] = [pieces[a]!, pieces[b]!];
    const colours = Math.min(1, away(one.colour, other.colour) / OTHER_COLOUR);
    const weight = Number(borders.pb[k]) + COLOUR_WEIGHT * colours + motions(one, other);
    links[a]?.push({ to: b, length, weight });
    links[b]?.push({ to: a, length, weight });
  });
  return links;
}

/** Grows until half of the frame is taken: the superpixels in their order, and what the region was like after each. */
function growth(seed: number, pieces: Piece[], links: Link[][], pixels: number) {
  const region = { area: 0, rim: 0, motion: [0, 0] };
  /** The region's own border, without the frame's rim: its length, and weight times length. */
  const outer = { length: 0, sum: 0 };
  /** What touches the region, and along what. */
  const around = new Map<number, { length: number; sum: number }>();
  const whole = links.map((list) => list.reduce((sum, { length }) => sum + length, 0));
  const taken = new Set<number>();
  const steps = [];
  for (let next = seed; next >= 0; next = cheapest(around, region, pieces, whole)) {
    const piece = pieces[next]!;
    taken.add(next);
    around.delete(next);
    const area = region.area + piece.area;
    region.motion = region.motion.map((one, k) => (one * region.area + Number(piece.motion[k]) * piece.area) / area);
    Object.assign(region, { area, rim: region.rim + piece.rim });
    for (const { to, length, weight } of links[next] ?? []) {
      const sign = taken.has(to) ? -1 : 1;
      outer.length += sign * length;
      outer.sum += sign * length * weight;
      if (sign < 0) continue;
      const before = around.get(to) ?? { length: 0, sum: 0 };
      around.set(to, { length: before.length + length, sum: before.sum + length * weight });
    }
    const strength = Math.max(0, outer.sum) / Math.max(1, outer.length + region.rim);
    const score = strength + SIZE_WEIGHT * Math.sqrt(Math.sqrt(area / pixels));
    steps.push({ taken: taken.size, area, score });
    if (area > MOST * pixels) break;
  }
  return { order: [...taken], steps };
}

/**
 * @param whole length of all borders of each
 * @returns -1 where nothing is left
 */
function cheapest(
  around: Map<number, { length: number; sum: number }>,
  region: Moving,
  pieces: Piece[],
  whole: number[],
): number {
  let [best, least] = [-1, Infinity];
  for (const [to, { length, sum }] of around) {
    const enclosed = Math.min(1, length / Math.max(1, Number(whole[to])));
    const other = motions(pieces[to]!, region);
    const cost = sum / length + REGION_WEIGHT * other - ENCLOSED * enclosed;
    if (cost < least) [best, least] = [to, cost];
  }
  return best;
}

/** How far two motions are apart, 0 to 1. */
function motions(a: Moving, b: Moving) {
  return Math.min(1, away(a.motion, b.motion) / OTHER_MOTION);
}

function away(a: number[], b: number[]) {
  return Math.sqrt(a.reduce((sum, one, k) => sum + (one - Number(b[k])) ** 2, 0));
}

function add(sums: number[], values: (number | undefined)[]) {
  values.forEach((value, k) => (sums[k] = Number(sums[k]) + Number(value)));
}
