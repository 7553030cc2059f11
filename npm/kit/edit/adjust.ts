/**
 * Masks made ready for use: specks left out, objects grown or shrunk, their edges softened.
 *
 * Pieces are those of one label whose pixels touch at a side or a corner. Growing and shrinking go by the exact
 * distance between pixel centres (Meijster, Roerdink and Hesselink 2000, in two passes). Softening is three box
 * averages one after the other, in whole numbers: the same bytes everywhere.
 */

import { TraceCutError, checkNumber, checkedOptions, illegal, wholeNumber } from '../../check/errors.js';
import { type ObjectChoice, chosenLabels } from '../../check/masks.js';

/** What is done to the edges of masks. */
export interface MaskEdges {
  /** Pieces of fewer pixels of the masks become background, 0 to 1 000 000; 0 if not given. */
  smallest?: number;
  /**
   * Pixels of the masks by which objects grow over the background, or shrink where it is negative, -100 to 100; 0 if
   * not given.
   */
  grow?: number;
  /** Pixels of the masks on either side of their edge within which objects fade, 0 to 100; 0 if not given. */
  feather?: number;
}

/** A label for each pixel, row by row. */
export type Mask = { labels: Uint8Array; width: number; height: number };

export interface AdjustMaskOptions {
  /** That are meant: all but the background if not given. Others stay as they are. */
  objects?: ObjectChoice;
  /** In pixels, 0 to 1 000 000; 0 if not given. */
  smallest?: number;
  /** In pixels, -100 to 100; 0 if not given. */
  grow?: number;
  /** In pixels, 0 to 100; 0 if not given. */
  feather?: number;
}

const MOST = 100;
const MOST_PIXELS = 1_000_000;

/**
 * A mask without its specks, grown or shrunk, and how opaque the chosen objects are at each pixel.
 * @param mask a label for each pixel, row by row; stays as it is
 * @returns `alpha` is 255 where they are opaque
 */
export function adjustMask(
  mask: Mask,
  options: AdjustMaskOptions = {},
): { width: number; height: number; labels: Uint8Array<ArrayBuffer>; alpha: Uint8Array<ArrayBuffer> } {
  const { objects, ...edges } = checkedOptions(options, ['objects', 'smallest', 'grow', 'feather']);
  const { width, height } = mask ?? {};
  if (!(mask?.labels instanceof Uint8Array)) throw illegal('data', 'mask', mask, '{labels, width, height}');
  wholeNumber('data', 'mask.width', width, 1, 16384);
  wholeNumber('data', 'mask.height', height, 1, 16384);
  if (mask.labels.length !== width * height)
    throw new TraceCutError('data', `mask.labels has ${mask.labels.length} labels (expected ${width * height})`);
  const { smallest, grow, feather } = checkedEdges(edges);
  const chosen = chosenLabels(objects);
  const labels = grown(withoutSpecks(mask, chosen, smallest), chosen, grow).labels;
  return { width, height, labels, alpha: softAlpha({ labels, width, height }, chosen, feather) };
}

export function checkedEdges(edges: MaskEdges | undefined = {}): Required<MaskEdges> {
  const { smallest = 0, grow = 0, feather = 0 } = checkedOptions(edges, ['smallest', 'grow', 'feather']);
  checkNumber('smallest', smallest, 0, MOST_PIXELS);
  checkNumber('grow', grow, -MOST, MOST);
  checkNumber('feather', feather, 0, MOST);
  return { smallest, grow, feather };
}

export function withoutSpecks(
  { labels, width, height }: Mask,
  chosen: Uint8Array,
  smallest: number,
): { labels: Uint8Array<ArrayBuffer>; width: number; height: number } {
  const kept = Uint8Array.from(labels);
  if (smallest <= 1) return { labels: kept, width, height };
  const seen = new Uint8Array(labels.length);
  const piece = new Uint32Array(labels.length);
  for (let start = 0; start < labels.length; start += 1) {
    const label = Number(labels[start]);
    if (seen[start] || label === 0 || !chosen[label]) continue;
    const count = fillPiece({ labels, width, height }, start, seen, piece);
    if (count < smallest) for (let k = 0; k < count; k += 1) kept[Number(piece[k])] = 0;
  }
  return { labels: kept, width, height };
}

/**
 * @param seen set for the pixels of the piece
 * @param piece filled with them
 */
export function fillPiece(
  { labels, width, height }: Mask,
  start: number,
  seen: Uint8Array,
  piece: Uint32Array,
): number {
  let count = 1;
  piece[0] = start;
  seen[start] = 1;
  for (let next = 0; next < count; next += 1) {
    const p = Number(piece[next]);
    const x = p % width;
    const y = (p - x) / width;
    for (let ny = Math.max(0, y - 1); ny <= Math.min(height - 1, y + 1); ny += 1) {
      for (let nx = Math.max(0, x - 1); nx <= Math.min(width - 1, x + 1); nx += 1) {
        const n = ny * width + nx;
        if (seen[n] || labels[n] !== labels[start]) continue;
        seen[n] = 1;
        piece[count] = n;
        count += 1;
      }
    }
  }
  return count;
}

export function grown(
  { labels, width, height }: { labels: Uint8Array<ArrayBuffer>; width: number; height: number },
  chosen: Uint8Array,
  grow: number,
): { labels: Uint8Array<ArrayBuffer>; width: number; height: number } {
  if (grow === 0) return { labels, width, height };
  const result = Uint8Array.from(labels);
  if (grow > 0) {
    const near = nearestWithin(
      labels.map((label) => (chosen[label] ? label : 0)),
      width,
      height,
      grow,
    );
    for (let p = 0; p < result.length; p += 1) if (result[p] === 0) result[p] = Number(near[p]);
  } else {
    const others = labels.map((label) => (label > 0 && chosen[label] ? 0 : 1));
    const near = nearestWithin(others, width, height, -grow);
    for (let p = 0; p < result.length; p += 1) if (!others[p] && near[p]) result[p] = 0;
  }
  return { labels: result, width, height };
}

/** For each pixel the value of the nearest pixel that is not 0, where that is at most `reach` away, else 0. */
function nearestWithin(seeds: Uint8Array, width: number, height: number, reach: number) {
  const far = width + height;
  const { distance, value } = downColumns(seeds, width, height, far);
  const result = new Uint8Array(seeds.length);
  const most = reach * reach;
  const site = new Int32Array(width);
  const from = new Int32Array(width);
  for (let y = 0; y < height; y += 1) {
    const row = y * width;
    const high = (x: number) => Number(distance[row + x]) ** 2;
    const cost = (x: number, at: number) => (x - at) ** 2 + high(at);
    let top = 0;
    site[0] = from[0] = 0;
    for (let x = 1; x < width; x += 1) {
      while (top >= 0 && cost(Number(from[top]), Number(site[top])) > cost(Number(from[top]), x)) top -= 1;
      if (top < 0) {
        top = 0;
        site[0] = x;
        from[0] = 0;
        continue;
      }
      const s = Number(site[top]);
      // From here on the new one is nearer.
      const border = 1 + Math.floor((x * x - s * s + high(x) - high(s)) / (2 * (x - s)));
      if (border < width) {
        top += 1;
        site[top] = x;
        from[top] = border;
      }
    }
    for (let x = width - 1; x >= 0; x -= 1) {
      const s = Number(site[top]);
      if (cost(x, s) <= most) result[row + x] = Number(value[row + s]);
      if (x === from[top]) top -= 1;
    }
  }
  return result;
}

/**
 * For each pixel how far the nearest seed of its column is, and its value.
 * @param far where there is none
 */
function downColumns(seeds: Uint8Array, width: number, height: number, far: number) {
  const distance = new Uint16Array(seeds.length).fill(far);
  const value = new Uint8Array(seeds.length);
  const pass = (p: number, before: number) => {
    if (seeds[p]) {
      distance[p] = 0;
      value[p] = Number(seeds[p]);
    } else if (before >= 0 && Number(distance[before]) + 1 < Number(distance[p])) {
      distance[p] = Number(distance[before]) + 1;
      value[p] = Number(value[before]);
    }
  };
  for (let p = 0; p < seeds.length; p += 1) pass(p, p - width);
  for (let p = seeds.length - width - 1; p >= 0; p -= 1) pass(p, p + width);
  return { distance, value };
}

export function softAlpha(
  { labels, width, height }: Mask,
  chosen: Uint8Array,
  feather: number,
): Uint8Array<ArrayBuffer> {
  let alpha = new Uint8Array(labels.length);
  for (let p = 0; p < labels.length; p += 1) alpha[p] = chosen[Number(labels[p])] ? 255 : 0;
  const reach = Math.round(feather);
  for (let box = 0; box < 3; box += 1) {
    // Together they reach as far as the feather.
    const radius = Math.floor((reach + box) / 3);
    if (radius > 0) alpha = averaged(averaged(alpha, width, height, radius), height, width, radius);
  }
  return alpha;
}

/** Averages along rows; the result's rows are the columns, so that two calls do both. */
function averaged(values: Uint8Array, width: number, height: number, radius: number) {
  const result = new Uint8Array(values.length);
  const size = 2 * radius + 1;
  for (let y = 0; y < height; y += 1) {
    const row = y * width;
    // Beyond the frame it goes on as it ends.
    const at = (x: number) => Number(values[row + Math.min(width - 1, Math.max(0, x))]);
    let sum = radius;
    for (let x = -radius; x <= radius; x += 1) sum += at(x);
    for (let x = 0; x < width; x += 1) {
      result[x * height + y] = Math.floor(sum / size);
      sum += at(x + radius + 1) - at(x - radius);
    }
  }
  return result;
}
