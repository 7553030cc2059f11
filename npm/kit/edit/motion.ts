// Pictures and optical flow at the size of masks, which may be another, and interpolation of an object's shape along the flow.

import { TraceCutError, checkWholeNumber, illegal } from '../../check/errors.js';
import { encodeRuns } from '../../session/serialize.js';
import { type ImageEngine, createImageEngine } from '../../stages/image.js';
import type { FlowField } from '../../session/engine.js';
import type { MaskEditor, Paint } from './editor.js';

/** The pixels of a frame: RGBA bytes, row by row. */
export type Picture = { data: Uint8Array | Uint8ClampedArray; width: number; height: number };

export type FlowBetween = (from: Picture, to: Picture) => Promise<FlowField>;

export type Size = { width: number; height: number };

export function checkPicture(picture: Picture, t: number): Picture {
  const { data, width, height } = picture ?? {};
  if (!data || data.length !== 4 * width * height)
    throw new TraceCutError('data', `picture(${t}) is no {data, width, height} of RGBA bytes`);
  return picture;
}

/** Returns the place of each pixel. */
export function createPlaces({ width, height }: Size): { x: Float32Array; y: Float32Array } {
  const [x, y] = [new Float32Array(width * height), new Float32Array(width * height)];
  for (let p = 0; p < x.length; p += 1) [x[p], y[p]] = [p % width, Math.floor(p / width)];
  return { x, y };
}

/** Returns the flow at a place, in pixels of the masks. */
export function readFlow(flow: FlowField, x: number, y: number, { width, height }: Size): [number, number] {
  const [sx, sy] = [flow.width / width, flow.height / height];
  const column = Math.max(0, Math.min(flow.width - 1, Math.floor((x + 0.5) * sx)));
  const row = Math.max(0, Math.min(flow.height - 1, Math.floor((y + 0.5) * sy)));
  const f = row * flow.width + column;
  return [Number(flow.u[f]) / sx, Number(flow.v[f]) / sy];
}

/** Returns the pixel at a place; -1 outside of the frame. */
export function findPixel(x: number, y: number, { width, height }: Size): number {
  const [column, row] = [Math.floor(x + 0.5), Math.floor(y + 0.5)];
  return column >= 0 && row >= 0 && column < width && row < height ? row * width + column : -1;
}

/** Returns the colours of a picture at the size of the masks: of each pixel the mean over nine pixels of the picture. */
export function readColours({ data, width: w, height: h }: Picture, { width, height }: Size): Float32Array {
  const colours = new Float32Array(3 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    const x = Math.floor((((p % width) + 0.5) * w) / width);
    const y = Math.floor(((Math.floor(p / width) + 0.5) * h) / height);
    let count = 0;
    for (let j = Math.max(0, y - 1); j <= Math.min(h - 1, y + 1); j += 1) {
      for (let i = Math.max(0, x - 1); i <= Math.min(w - 1, x + 1); i += 1) {
        for (let c = 0; c < 3; c += 1) colours[3 * p + c]! += Number(data[4 * (j * w + i) + c]);
        count += 1;
      }
    }
    for (let c = 0; c < 3; c += 1) colours[3 * p + c]! /= count;
  }
  return colours;
}

/** Options of interpolated masks. */
export interface InterpolateOptions {
  /** The frames that masks come from; `both` if not given. */
  sides?: 'before' | 'both';
  /** Aborts the work: the promise rejects with its reason, and nothing is changed. */
  signal?: AbortSignal;
  /** Called for each frame with a new mask. */
  onFrame?: (reached: { t: number }) => void;
}

// Chosen by eye.

/** Colours that differ by less look alike: mean difference of red, green and blue, of 255. */
const MAX_COLOUR_DIFFERENCE = 24;
/** Weight of a pixel that does not look like the one that it came from. */
const UNLIKE_WEIGHT = 0.25;
/** Least share of the objects' pixels that look like those they came from. */
const MIN_ALIKE_SHARE = 0.6;

/** The mask of a frame as it came from one side, with a weight for each pixel. */
type MovedMask = { labels: Uint8Array; weights: Float32Array; share: number };

/** Returns what replaces the masks of the frames, `from <= t < to`. */
export async function interpolate(
  editor: MaskEditor,
  range: { from: number; to: number },
  options: InterpolateOptions & { picture: (t: number) => Picture | Promise<Picture> },
  openEngine: (() => Promise<ImageEngine>) | undefined,
): Promise<Paint[]> {
  const { from, to } = range;
  const { sides = 'both', picture, signal, onFrame } = options;
  checkRange(editor, range, sides);
  const engine = await (openEngine ?? createImageEngine)();
  try {
    const moved = new Map<number, MovedMask[]>();
    const starts = sides === 'both' ? [from - 1, to] : [from - 1];
    for (const start of starts) {
      const step = start < from ? 1 : -1;
      let before = checkPicture(await picture(start), start);
      let labels: Uint8Array = editor.labels(start);
      for (let t = start + step; t >= from && t < to; t += step) {
        signal?.throwIfAborted();
        const now = checkPicture(await picture(t), t);
        const mask = await moveMask(labels, [before, now], editor, engine);
        if (sides === 'before' && mask.share < MIN_ALIKE_SHARE) break;
        moved.set(t, [...(moved.get(t) ?? []), { ...mask, weights: mask.weights.map((w) => w / Math.abs(t - start)) }]);
        if (start === starts.at(-1)) onFrame?.({ t });
        [before, labels] = [now, mask.labels];
      }
    }
    signal?.throwIfAborted();
    if (moved.size === 0) throw new TraceCutError('state', `frame ${from} does not look like frame ${from - 1}`);
    return toPaints(new Map([...moved].map(([t, masks]) => [t, elect(masks)])));
  } finally {
    if (!openEngine) engine.close();
  }
}

function checkRange(editor: MaskEditor, { from, to }: { from: number; to: number }, sides: string) {
  if (sides !== 'before' && sides !== 'both') throw illegal('param', 'sides', sides, "'before' or 'both'");
  checkWholeNumber('param', 'from', from, 1, editor.numFrames - 1);
  const { first, last } = editor.shotOf(from);
  if (from === first) throw illegal('param', 'from', from, 'a frame with another before it in its shot');
  checkWholeNumber('param', 'to', to, from + 1, sides === 'both' ? last : last + 1);
}

/** Moves a mask to the next frame. */
async function moveMask(
  labels: Uint8Array,
  [before, now]: [Picture, Picture],
  size: { width: number; height: number },
  engine: ImageEngine,
): Promise<MovedMask> {
  const back = await engine.flow(now, before);
  const [from, to] = [readColours(before, size), readColours(now, size)];
  const moved = new Uint8Array(labels.length);
  const weights = new Float32Array(labels.length).fill(UNLIKE_WEIGHT);
  let [numObject, numAlike] = [0, 0];
  for (let p = 0; p < labels.length; p += 1) {
    const [x, y] = [p % size.width, Math.floor(p / size.width)];
    const [u, v] = readFlow(back, x, y, size);
    const q = findPixel(x + u, y + v, size);
    if (q < 0) continue;
    moved[p] = Number(labels[q]);
    let difference = 0;
    for (let c = 0; c < 3; c += 1) difference += Math.abs(Number(to[3 * p + c]) - Number(from[3 * q + c])) / 3;
    const isAlike = difference < MAX_COLOUR_DIFFERENCE;
    if (isAlike) weights[p] = 1;
    if (moved[p] === 0) continue;
    numObject += 1;
    numAlike += Number(isAlike);
  }
  return { labels: moved, weights, share: numObject === 0 ? 1 : numAlike / numObject };
}

/** Returns for each pixel the label with most weight, the first of equal ones. */
function elect([first, second]: MovedMask[]): Uint8Array {
  if (!second) return first!.labels;
  return first!.labels.map((label, p) =>
    Number(second.weights[p]) > Number(first!.weights[p]) ? Number(second.labels[p]) : label,
  );
}

/** Returns the paints that make the masks of frames what they should be, the background first. */
function toPaints(masks: Map<number, Uint8Array>): Paint[] {
  const labels = [...new Set([...masks.values()].flatMap((mask) => [...new Set(mask)]))].sort((a, b) => a - b);
  return labels.map((label) => {
    const part = (mask: Uint8Array) => ({
      region: encodeRuns(mask.map((found) => Number(found === label))),
      evidence: 1,
    });
    return { label, over: null, parts: new Map([...masks].map(([t, mask]) => [t, part(mask)])) };
  });
}
