// An edit of one frame carried to others: its region goes with the optical flow, from frame to frame, as long as the
// picture there looks like where it came from.

import { TraceCutError, checkNumber, illegal, wholeNumber } from '../../check/errors.js';
import { type Runs as Region, areasOf, decodeRuns, encodeRuns } from '../../session/runs.js';
import { type ImageEngine, createImageEngine } from '../../stages/image.js';
import type { FlowField } from '../../session/engine.js';
import type { Edit, MaskEditor, Paint, Part } from './editor.js';

/** The pixels of a frame: RGBA bytes, row by row. */
export type Picture = { data: Uint8Array | Uint8ClampedArray; width: number; height: number };

/** How far and how long an edit is carried. */
export interface CarryOptions {
  /** Where it ends at the latest on the way back; the shot's first frame, or the clip's, if not given. */
  first?: number;
  /** Where it ends at the latest on the way on; the shot's last frame, or the clip's, if not given. */
  last?: number;
  /** Where it ends, 0 to 1: the share of the region that looks like what it came from; .6 if not given. */
  leastEvidence?: number;
  /** Ends the work: the promise rejects with its reason. */
  signal?: AbortSignal;
  /** Hears of each frame that was reached. */
  onFrame?: (reached: { t: number; evidence: number }) => void;
}

/** How far an edit was carried: the first and the last frame that have it. */
export type Carried = { first: number; last: number };

export type FlowBetween = (from: Picture, to: Picture) => Promise<FlowField>;

/** Colours that differ by less are the same, as the mean over red, green and blue. */
const SAME_COLOUR = 24;
/** A region that grows or shrinks by more from one frame to the next has lost its way. */
const MOST_CHANGE = 1.6;

/** Carries what an edit paints to the frames before and after it, as parts of the same edit. */
export async function carry(
  editor: MaskEditor,
  edit: Edit,
  options: CarryOptions & { picture: (t: number) => Picture | Promise<Picture> },
  open: (() => Promise<ImageEngine>) | undefined,
): Promise<Carried> {
  const how = checked(editor, edit, options);
  const engine = await (open ?? createImageEngine)();
  const reached = { first: how.start, last: how.start };
  try {
    for (const paint of edit.paints) {
      for (const step of [1, -1]) {
        for await (const { t, region, evidence } of moved(paint, step, how, editor, engine)) {
          editor.extend(edit, t, region, evidence, paint);
          reached.first = Math.min(reached.first, t);
          reached.last = Math.max(reached.last, t);
          how.onFrame?.({ t, evidence });
        }
      }
    }
  } finally {
    if (!open) engine.close();
  }
  return reached;
}

/**
 * Gives where what was painted is in the frames on one side of it, one after the other.
 * @param step 1 or -1
 */
async function* moved(
  paint: Paint,
  step: number,
  { start, picture, first, last, least, signal }: ReturnType<typeof checked>,
  masks: { width: number; height: number },
  engine: ImageEngine,
) {
  let { region } = paint.parts.get(start)!;
  let before = checkedPicture(await picture(start), start);
  for (let t = start + step; t >= first && t <= last; t += step) {
    signal?.throwIfAborted();
    const now = checkedPicture(await picture(t), t);
    const there = move(region, await engine.flow(now, before), [before, now], masks);
    signal?.throwIfAborted();
    if (there.evidence < least) return;
    ({ region } = there);
    yield { t, region, evidence: there.evidence };
    before = now;
  }
}

function checked(
  editor: MaskEditor,
  edit: Edit,
  options: CarryOptions & { picture: (t: number) => Picture | Promise<Picture> },
) {
  const start = [...(edit?.paints?.[0]?.parts.keys() ?? [])][0];
  if (start === undefined) throw illegal('param', 'edit', edit, 'an edit that paints');
  // What is beyond a cut is another scene.
  const shot = editor.shots?.find(({ first, last }) => first <= start && start <= last);
  const { picture, first = shot?.first ?? 0, last = shot?.last ?? editor.numFrames - 1, leastEvidence = 0.6 } = options;
  wholeNumber('param', 'first', first, 0, start);
  wholeNumber('param', 'last', last, start, editor.numFrames - 1);
  checkNumber('leastEvidence', leastEvidence, 0, 1);
  return { start, picture, first, last, least: leastEvidence, signal: options.signal, onFrame: options.onFrame };
}

function checkedPicture(picture: Picture, t: number) {
  const { data, width, height } = picture ?? {};
  if (!data || data.length !== 4 * width * height)
    throw new TraceCutError('data', `picture(${t}) is no {data, width, height} of RGBA bytes`);
  return picture;
}

/**
 * Where a region is in the next frame. Each pixel there looks back along the flow: it belongs to the region if most of
 * what it came from does.
 * @param back from each pixel of the next picture to this one, in its pixels
 * @param pictures this and the next, of one size
 */
export function move(
  region: Region,
  back: FlowField,
  [from, to]: [Picture, Picture],
  { width, height }: { width: number; height: number },
): { region: Region; evidence: number } {
  const before = decodeRuns(region);
  const [sx, sy] = [back.width / width, back.height / height];
  const pixels = new Uint8Array(width * height);
  let [alike, count] = [0, 0];
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const fx = Math.min(back.width - 1, Math.floor((x + 0.5) * sx));
      const fy = Math.min(back.height - 1, Math.floor((y + 0.5) * sy));
      const f = fy * back.width + fx;
      const [u, v] = [Number(back.u[f]), Number(back.v[f])];
      const [px, py] = [x + u / sx, y + v / sy];
      if (share(before, width, height, px, py) < 0.5) continue;
      pixels[y * width + x] = 1;
      count += 1;
      alike += Number(difference(from, [fx + u, fy + v], to, [fx, fy]) < SAME_COLOUR);
    }
  }
  const change = count / Math.max(1, width * height - Number(areasOf(region)[0]));
  const kept = count > 0 && change < MOST_CHANGE && change > 1 / MOST_CHANGE;
  return { region: encodeRuns(pixels), evidence: kept ? alike / count : 0 };
}

/** How much of the pixel at a place between pixels is set, 0 to 1; nothing is beyond the frame. */
function share(pixels: Uint8Array, width: number, height: number, x: number, y: number) {
  const [left, top] = [Math.floor(x), Math.floor(y)];
  if (left < -1 || top < -1 || left >= width || top >= height) return 0;
  const [ax, ay] = [x - left, y - top];
  const one = (i: number, j: number) =>
    i >= 0 && j >= 0 && i < width && j < height ? Number(pixels[j * width + i]) : 0;
  const upper = (1 - ax) * one(left, top) + ax * one(left + 1, top);
  const lower = (1 - ax) * one(left, top + 1) + ax * one(left + 1, top + 1);
  return (1 - ay) * upper + ay * lower;
}

/** How far the colours at two places are apart, as the mean over red, green and blue. */
function difference(from: Picture, a: [number, number], to: Picture, b: [number, number]) {
  const [p, q] = [pixelAt(from, a), pixelAt(to, b)];
  const of = (c: number) => Math.abs(Number(from.data[p + c]) - Number(to.data[q + c]));
  return (of(0) + of(1) + of(2)) / 3;
}

function pixelAt({ width, height }: Picture, [x, y]: [number, number]) {
  const column = Math.min(width - 1, Math.max(0, Math.round(x)));
  const row = Math.min(height - 1, Math.max(0, Math.round(y)));
  return 4 * (row * width + column);
}
