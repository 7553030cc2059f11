// Regions of a frame: painted by strokes, as runs, and divided into pieces.

import { TraceCutError, illegal, isPlainObject, wholeNumber } from '../../check/errors.js';
import { fillPiece } from './adjust.js';

/**
 * Pixels of a frame, row by row: pairs of the first pixel of a run and its length, ascending, apart from each other.
 * @typedef {Uint32Array<ArrayBuffer>} Region
 */

/**
 * What a brush paints in a frame.
 * @typedef {object} BrushStroke
 * @property {number} t the frame, from 0
 * @property {ArrayLike<number>} points x0, y0, x1, y1, … along its way, in mask pixels, pixel centres at whole numbers
 * @property {number} radius half its width, in mask pixels
 */

const MAX_RADIUS = 16384;

/**
 * The region of all pixels that are not 0.
 * @param {ArrayLike<number>} pixels row by row
 * @returns {Region}
 */
export function regionOf(pixels) {
  /** @type {number[]} */
  const runs = [];
  for (let p = 0; p < pixels.length; p += 1) {
    if (!pixels[p]) continue;
    const start = p;
    while (p < pixels.length && pixels[p]) p += 1;
    runs.push(start, p - start);
  }
  return Uint32Array.from(runs);
}

/**
 * A byte for each pixel: 1 in the region.
 * @param {Region} region
 * @param {number} size number of pixels
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function pixelsOf(region, size) {
  const pixels = new Uint8Array(size);
  for (let k = 0; k < region.length; k += 2) pixels.fill(1, at(region, k), at(region, k) + at(region, k + 1));
  return pixels;
}

/**
 * How many pixels a region has.
 * @param {Region} region
 */
export function areaOf(region) {
  let area = 0;
  for (let k = 1; k < region.length; k += 2) area += at(region, k);
  return area;
}

/**
 * What a round brush covers: all pixels within its radius of its way.
 * @param {BrushStroke} stroke
 * @param {number} width of the masks
 * @param {number} height
 * @returns {Region}
 */
export function strokeRegion(stroke, width, height) {
  const { points, radius } = checkedStroke(stroke);
  const pixels = new Uint8Array(width * height);
  for (let k = 0; k < points.length; k += 2) {
    const end = Math.min(k + 2, points.length - 2);
    paintLine(pixels, width, height, [...points.slice(k, k + 2), ...points.slice(end, end + 2)], radius);
  }
  return regionOf(pixels);
}

/**
 * @param {unknown} stroke
 * @returns {{points: number[], radius: number}}
 */
function checkedStroke(stroke) {
  const { points, radius } = isPlainObject(stroke) ? stroke : { points: undefined, radius: undefined };
  if (typeof radius !== 'number' || !(radius >= 0 && radius <= MAX_RADIUS))
    throw illegal('param', 'stroke.radius', radius, `mask pixels, 0..=${MAX_RADIUS}`);
  if (!(Array.isArray(points) || ArrayBuffer.isView(points)))
    throw illegal('param', 'stroke.points', points, 'x0, y0, x1, y1, …');
  const list = Array.from(/** @type {ArrayLike<number>} */ (/** @type {unknown} */ (points)));
  if (list.length === 0 || list.length % 2 !== 0)
    throw new TraceCutError('param', `stroke.points has ${list.length} numbers (expected an even number, 2 or more)`);
  const wrong = list.findIndex((value) => !Number.isFinite(value));
  if (wrong >= 0) throw illegal('param', `stroke.points[${wrong}]`, list[wrong], 'a finite number');
  return { points: list, radius };
}

/**
 * @param {Uint8Array} pixels
 * @param {number} width
 * @param {number} height
 * @param {number[]} line x and y of both ends
 * @param {number} radius
 */
function paintLine(pixels, width, height, [x0 = 0, y0 = 0, x1 = 0, y1 = 0], radius) {
  // A brush that is thinner than a pixel still covers the pixel that it is in.
  const reach = Math.max(radius, Math.SQRT1_2);
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = dx * dx + dy * dy;
  const [top, bottom] = [Math.ceil(Math.min(y0, y1) - reach), Math.floor(Math.max(y0, y1) + reach)];
  const [left, right] = [Math.ceil(Math.min(x0, x1) - reach), Math.floor(Math.max(x0, x1) + reach)];
  for (let y = Math.max(0, top); y <= Math.min(height - 1, bottom); y += 1) {
    for (let x = Math.max(0, left); x <= Math.min(width - 1, right); x += 1) {
      const along = length > 0 ? Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / length)) : 0;
      const [ax, ay] = [x - x0 - along * dx, y - y0 - along * dy];
      if (ax * ax + ay * ay <= reach * reach) pixels[y * width + x] = 1;
    }
  }
}

/**
 * Refuses what is no region of a frame of `size` pixels.
 * @param {unknown} region
 * @param {number} size
 * @returns {Region}
 */
export function checkedRegion(region, size) {
  if (!(region instanceof Uint32Array) || region.length % 2 !== 0)
    throw illegal('data', 'region', region, 'a Uint32Array of pairs: first pixel and length of each run');
  let end = 0;
  for (let k = 0; k < region.length; k += 2) {
    const from = wholeNumber('data', `region[${k}]`, region[k], end, size);
    end = from + wholeNumber('data', `region[${k + 1}]`, region[k + 1], 1, size - from);
  }
  return /** @type {Region} */ (region);
}

/**
 * @param {Region} region
 * @param {number} k
 */
function at(region, k) {
  return /** @type {number} */ (region[k]);
}

/** @typedef {import('./adjust.js').Mask} Mask */

/**
 * The piece of a mask at a place: all pixels of that label which hang together with it, at a side or a corner.
 * @param {Mask} mask
 * @param {{x: number, y: number}} place in pixels of the mask, pixel centres at whole numbers
 * @returns {Region} for `MaskEditor.paint`
 */
export function pieceRegion(mask, { x, y }) {
  const { width, height } = mask;
  const [column, row] = [wholeNumber('param', 'x', Math.round(x), 0, width - 1), Math.round(y)];
  wholeNumber('param', 'y', row, 0, height - 1);
  const seen = new Uint8Array(width * height);
  fillPiece(mask, row * width + column, seen, new Uint32Array(width * height));
  return regionOf(seen);
}

/**
 * The object that strokes lie on most, divided among them: each of its pixels goes to the nearest stroke.
 * @param {Mask} mask
 * @param {readonly BrushStroke[]} strokes two or more in this frame
 * @returns {{label: number, regions: Region[]}} a region for each stroke
 */
export function divideRegions(mask, strokes) {
  const { labels, width, height } = mask;
  if (!Array.isArray(strokes) || strokes.length < 2)
    throw illegal('param', 'strokes', strokes, 'a list of two or more strokes {t, points, radius}');
  const covered = new Uint32Array(256);
  const ways = strokes.map((stroke) => {
    const pixels = pixelsOf(strokeRegion(stroke, width, height), width * height);
    for (let p = 0; p < pixels.length; p += 1)
      if (pixels[p]) covered[Number(labels[p])] = Number(covered[Number(labels[p])]) + 1;
    return Array.from(checkedStroke(stroke).points);
  });
  const label = covered.reduce((best, count, one) => (one > 0 && count > Number(covered[best]) ? one : best), 1);
  if (covered[label] === 0) throw illegal('param', 'strokes', strokes, 'strokes on an object of this frame');
  const parts = strokes.map(() => new Uint8Array(width * height));
  for (let p = 0; p < labels.length; p += 1) {
    if (labels[p] !== label) continue;
    const away = ways.map((way) => distance(way, p % width, Math.floor(p / width)));
    const nearest = away.reduce((best, one, k) => (one < Number(away[best]) ? k : best), 0);
    const part = parts[nearest];
    if (part) part[p] = 1;
  }
  return { label, regions: parts.map(regionOf) };
}

/**
 * The square of how far a place is from a way.
 * @param {number[]} way x0, y0, x1, y1, …
 * @param {number} x
 * @param {number} y
 */
function distance(way, x, y) {
  let least = Infinity;
  for (let k = 0; k < way.length; k += 2) {
    const [ax, ay] = [Number(way[k]), Number(way[k + 1])];
    const [bx, by] = [way[k + 2] ?? ax, way[k + 3] ?? ay];
    const square = (bx - ax) ** 2 + (by - ay) ** 2;
    const along = square > 0 ? Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / square)) : 0;
    least = Math.min(least, (ax + along * (bx - ax) - x) ** 2 + (ay + along * (by - ay) - y) ** 2);
  }
  return least;
}
