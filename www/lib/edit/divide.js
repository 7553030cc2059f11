// Which pixels of an object are meant when it is taken apart by hand: a piece of it, or what lies nearest to each stroke.

import { illegal, wholeNumber } from '../errors.js';
import { fillPiece } from '../export/adjust.js';
import { checkedStroke, pixelsOf, regionOf, strokeRegion } from './regions.js';

/** @typedef {import('./regions.js').Region} Region */
/** @typedef {import('../export/adjust.js').Mask} Mask */

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
 * @param {readonly import('./regions.js').BrushStroke[]} strokes two or more in this frame
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
