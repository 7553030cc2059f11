/**
 * Masks made ready for use: specks removed, objects grown or shrunk, their edges softened.
 *
 * A piece is a connected set of pixels of one label, which touch at a side or a corner. Growing and shrinking use the
 * exact distance between pixel centres (Meijster, Roerdink and Hesselink 2000, in two passes). Softening is three box
 * averages in a row, in whole numbers: the same bytes everywhere.
 */

import { TraceCutError, checkNumber, checkOptions, checkWholeNumber, illegal } from '../../check/errors.js';
import { type ObjectChoice, selectLabels } from '../../check/masks.js';

/** Adjustments of the edges of masks. */
export interface MaskEdges {
  /** Pieces of fewer pixels of the masks become background, 0 to 1 000 000; 0 if not given. */
  smallest?: number;
  /** Pixels of the masks by which objects grow, or shrink if negative, -100 to 100; 0 if not given. */
  grow?: number;
  /** Pixels of the masks on either side of their edge within which objects fade, 0 to 100; 0 if not given. */
  feather?: number;
}

/** A label for each pixel, row by row. */
export type Mask = { labels: Uint8Array; width: number; height: number };

/** Options of `adjustMask`. */
export interface AdjustMaskOptions {
  /** Objects to adjust; all but the background if not given. Others stay as they are. */
  objects?: ObjectChoice;
  /** Pieces of fewer pixels become background, 0 to 1 000 000; 0 if not given. */
  smallest?: number;
  /** Pixels by which objects grow, or shrink if negative, -100 to 100; 0 if not given. */
  grow?: number;
  /** Pixels on either side of their edge within which objects fade, 0 to 100; 0 if not given. */
  feather?: number;
}

/** Largest `grow` and `feather`. */
const MAX_LENGTH_PX = 100;
/** Largest `smallest`. */
const MAX_SPECK_PX = 1_000_000;

/**
 * Removes the specks of a mask, grows or shrinks its objects, and computes the opacity of the selected objects at each
 * pixel.
 * @param mask a label for each pixel, row by row; it is not changed
 * @returns `alpha` is 255 where they are opaque
 */
export function adjustMask(
  mask: Mask,
  options: AdjustMaskOptions = {},
): { width: number; height: number; labels: Uint8Array<ArrayBuffer>; alpha: Uint8Array<ArrayBuffer> } {
  const { objects, ...edges } = checkOptions(options, ['objects', 'smallest', 'grow', 'feather']);
  const { width, height } = mask ?? {};
  if (!(mask?.labels instanceof Uint8Array)) throw illegal('data', 'mask', mask, '{labels, width, height}');
  checkWholeNumber('data', 'mask.width', width, 1, 16384);
  checkWholeNumber('data', 'mask.height', height, 1, 16384);
  if (mask.labels.length !== width * height)
    throw new TraceCutError('data', `mask.labels has ${mask.labels.length} labels (expected ${width * height})`);
  const { smallest, grow, feather } = checkEdges(edges);
  const selected = selectLabels(objects);
  const labels = growObjects(removeSpecks(mask, selected, smallest), selected, grow).labels;
  return { width, height, labels, alpha: computeAlpha({ labels, width, height }, selected, feather) };
}

export function checkEdges(edges: MaskEdges | undefined = {}): Required<MaskEdges> {
  const { smallest = 0, grow = 0, feather = 0 } = checkOptions(edges, ['smallest', 'grow', 'feather']);
  checkNumber('smallest', smallest, 0, MAX_SPECK_PX);
  checkNumber('grow', grow, -MAX_LENGTH_PX, MAX_LENGTH_PX);
  checkNumber('feather', feather, 0, MAX_LENGTH_PX);
  return { smallest, grow, feather };
}

export function removeSpecks(
  { labels, width, height }: Mask,
  selected: Uint8Array,
  smallest: number,
): { labels: Uint8Array<ArrayBuffer>; width: number; height: number } {
  const result = Uint8Array.from(labels);
  if (smallest <= 1) return { labels: result, width, height };
  const visited = new Uint8Array(labels.length);
  const piece = new Uint32Array(labels.length);
  for (let start = 0; start < labels.length; start += 1) {
    const label = Number(labels[start]);
    if (visited[start] || label === 0 || !selected[label]) continue;
    const count = fillPiece({ labels, width, height }, start, visited, piece);
    if (count < smallest) for (let k = 0; k < count; k += 1) result[Number(piece[k])] = 0;
  }
  return { labels: result, width, height };
}

/**
 * Collects the pixels of the piece that contains pixel `start`.
 * @param visited set for the pixels of the piece
 * @param piece filled with them
 * @returns their number
 */
export function fillPiece(
  { labels, width, height }: Mask,
  start: number,
  visited: Uint8Array,
  piece: Uint32Array,
): number {
  let count = 1;
  piece[0] = start;
  visited[start] = 1;
  for (let next = 0; next < count; next += 1) {
    const p = Number(piece[next]);
    const x = p % width;
    const y = (p - x) / width;
    for (let ny = Math.max(0, y - 1); ny <= Math.min(height - 1, y + 1); ny += 1) {
      for (let nx = Math.max(0, x - 1); nx <= Math.min(width - 1, x + 1); nx += 1) {
        const n = ny * width + nx;
        if (visited[n] || labels[n] !== labels[start]) continue;
        visited[n] = 1;
        piece[count] = n;
        count += 1;
      }
    }
  }
  return count;
}

export function growObjects(
  { labels, width, height }: { labels: Uint8Array<ArrayBuffer>; width: number; height: number },
  selected: Uint8Array,
  grow: number,
): { labels: Uint8Array<ArrayBuffer>; width: number; height: number } {
  if (grow === 0) return { labels, width, height };
  const result = Uint8Array.from(labels);
  if (grow > 0) {
    const nearest = findNearest(
      labels.map((label) => (selected[label] ? label : 0)),
      width,
      height,
      grow,
    );
    for (let p = 0; p < result.length; p += 1) if (result[p] === 0) result[p] = Number(nearest[p]);
  } else {
    const background = labels.map((label) => (label > 0 && selected[label] ? 0 : 1));
    const nearest = findNearest(background, width, height, -grow);
    for (let p = 0; p < result.length; p += 1) if (!background[p] && nearest[p]) result[p] = 0;
  }
  return { labels: result, width, height };
}

/** Returns for each pixel the value of the nearest pixel that is not 0 and at most `reach` away, else 0. */
function findNearest(seeds: Uint8Array, width: number, height: number, reach: number) {
  const unreachable = width + height;
  const { distance, value } = scanColumns(seeds, width, height, unreachable);
  const result = new Uint8Array(seeds.length);
  const maxSquare = reach * reach;
  const site = new Int32Array(width);
  const from = new Int32Array(width);
  for (let y = 0; y < height; y += 1) {
    const row = y * width;
    const squareInColumn = (x: number) => Number(distance[row + x]) ** 2;
    const cost = (x: number, seed: number) => (x - seed) ** 2 + squareInColumn(seed);
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
      // From here on the new seed is nearer.
      const border = 1 + Math.floor((x * x - s * s + squareInColumn(x) - squareInColumn(s)) / (2 * (x - s)));
      if (border < width) {
        top += 1;
        site[top] = x;
        from[top] = border;
      }
    }
    for (let x = width - 1; x >= 0; x -= 1) {
      const s = Number(site[top]);
      if (cost(x, s) <= maxSquare) result[row + x] = Number(value[row + s]);
      if (x === from[top]) top -= 1;
    }
  }
  return result;
}

/**
 * Returns for each pixel the distance to the nearest seed of its column, and the value of that seed.
 * @param unreachable distance if the column has no seed
 */
function scanColumns(seeds: Uint8Array, width: number, height: number, unreachable: number) {
  const distance = new Uint16Array(seeds.length).fill(unreachable);
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

export function computeAlpha(
  { labels, width, height }: Mask,
  selected: Uint8Array,
  feather: number,
): Uint8Array<ArrayBuffer> {
  let alpha = new Uint8Array(labels.length);
  for (let p = 0; p < labels.length; p += 1) alpha[p] = selected[Number(labels[p])] ? 255 : 0;
  const reach = Math.round(feather);
  for (let box = 0; box < 3; box += 1) {
    // Their radii add up to the feather.
    const radius = Math.floor((reach + box) / 3);
    if (radius > 0) alpha = averageRows(averageRows(alpha, width, height, radius), height, width, radius);
  }
  return alpha;
}

/** Averages along rows and transposes the result, so that two calls average in both directions. */
function averageRows(values: Uint8Array, width: number, height: number, radius: number) {
  const result = new Uint8Array(values.length);
  const size = 2 * radius + 1;
  for (let y = 0; y < height; y += 1) {
    const row = y * width;
    // Beyond the frame the first and last values continue.
    const valueAt = (x: number) => Number(values[row + Math.min(width - 1, Math.max(0, x))]);
    let sum = radius;
    for (let x = -radius; x <= radius; x += 1) sum += valueAt(x);
    for (let x = 0; x < width; x += 1) {
      result[x * height + y] = Math.floor(sum / size);
      sum += valueAt(x + radius + 1) - valueAt(x - radius);
    }
  }
  return result;
}
