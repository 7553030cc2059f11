// Carries an edit of one frame to others: its region moves with the optical flow from frame to frame, as long as the
// picture there looks like the one it came from.

import { TraceCutError, checkNumber, checkWholeNumber, illegal } from '../../check/errors.js';
import { type Runs as Region, countPixels, decodeRuns, encodeRuns } from '../../session/runs.js';
import { type ImageEngine, createImageEngine } from '../../stages/image.js';
import type { FlowField } from '../../session/engine.js';
import type { Edit, MaskEditor, Paint, Part } from './editor.js';

/** The pixels of a frame: RGBA bytes, row by row. */
export type Picture = { data: Uint8Array | Uint8ClampedArray; width: number; height: number };

/** Limits on carrying an edit. */
export interface CarryOptions {
  /** First frame that it may reach; the first of the shot, or of the clip, if not given. */
  first?: number;
  /** Last frame that it may reach; the last of the shot, or of the clip, if not given. */
  last?: number;
  /** Share of the region that must look like the frame before, 0 to 1; .6 if not given. */
  minEvidence?: number;
  /** Aborts the work: the promise rejects with its reason. */
  signal?: AbortSignal;
  /** Called for each frame that was reached. */
  onFrame?: (reached: { t: number; evidence: number }) => void;
}

/** The first and the last frame that have the edit. */
export type CarryRange = { first: number; last: number };

export type FlowBetween = (from: Picture, to: Picture) => Promise<FlowField>;

/** Colours that differ by less count as equal: mean difference of red, green and blue, of 255. Chosen by eye. */
const MAX_COLOUR_DIFFERENCE = 24;
/** Largest factor by which a region's area may change from one frame to the next; beyond it is lost. Chosen by eye. */
const MAX_AREA_CHANGE = 1.6;

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
      for (const step of [1, -1]) {
        for await (const { t, region, evidence } of followRegion(paint, step, settings, editor, engine)) {
          editor.extend(edit, t, region, evidence, paint);
          range.first = Math.min(range.first, t);
          range.last = Math.max(range.last, t);
          settings.onFrame?.({ t, evidence });
        }
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
  paint: Paint,
  step: number,
  { start, picture, first, last, minEvidence, signal }: ReturnType<typeof checkCarry>,
  masks: { width: number; height: number },
  engine: ImageEngine,
) {
  let { region } = paint.parts.get(start)!;
  let before = checkPicture(await picture(start), start);
  for (let t = start + step; t >= first && t <= last; t += step) {
    signal?.throwIfAborted();
    const now = checkPicture(await picture(t), t);
    const next = moveRegion(region, await engine.flow(now, before), [before, now], masks);
    signal?.throwIfAborted();
    if (next.evidence < minEvidence) return;
    ({ region } = next);
    yield { t, region, evidence: next.evidence };
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
  // Beyond a cut there is another scene.
  const shot = editor.shots?.find(({ first, last }) => first <= start && start <= last);
  const { picture, first = shot?.first ?? 0, last = shot?.last ?? editor.numFrames - 1, minEvidence = 0.6 } = options;
  checkWholeNumber('param', 'first', first, 0, start);
  checkWholeNumber('param', 'last', last, start, editor.numFrames - 1);
  checkNumber('minEvidence', minEvidence, 0, 1);
  return { start, picture, first, last, minEvidence, signal: options.signal, onFrame: options.onFrame };
}

function checkPicture(picture: Picture, t: number) {
  const { data, width, height } = picture ?? {};
  if (!data || data.length !== 4 * width * height)
    throw new TraceCutError('data', `picture(${t}) is no {data, width, height} of RGBA bytes`);
  return picture;
}

/**
 * Finds a region in the next frame. Each pixel there looks back along the flow: it belongs to the region if most of the
 * pixel that it came from does.
 * @param back from each pixel of the next picture to this one, in its pixels
 * @param pictures this and the next, of one size
 */
function moveRegion(
  region: Region,
  back: FlowField,
  [from, to]: [Picture, Picture],
  { width, height }: { width: number; height: number },
): { region: Region; evidence: number } {
  const before = decodeRuns(region);
  const [sx, sy] = [back.width / width, back.height / height];
  const pixels = new Uint8Array(width * height);
  let [similar, count] = [0, 0];
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const fx = Math.min(back.width - 1, Math.floor((x + 0.5) * sx));
      const fy = Math.min(back.height - 1, Math.floor((y + 0.5) * sy));
      const f = fy * back.width + fx;
      const [u, v] = [Number(back.u[f]), Number(back.v[f])];
      const [px, py] = [x + u / sx, y + v / sy];
      if (interpolate(before, width, height, px, py) < 0.5) continue;
      pixels[y * width + x] = 1;
      count += 1;
      similar += Number(compareColours(from, [fx + u, fy + v], to, [fx, fy]) < MAX_COLOUR_DIFFERENCE);
    }
  }
  const change = count / Math.max(1, width * height - Number(countPixels(region)[0]));
  const isPlausible = count > 0 && change < MAX_AREA_CHANGE && change > 1 / MAX_AREA_CHANGE;
  return { region: encodeRuns(pixels), evidence: isPlausible ? similar / count : 0 };
}

/** Interpolates the mask at a place between pixels, 0 to 1; it is 0 beyond the frame. */
function interpolate(pixels: Uint8Array, width: number, height: number, x: number, y: number) {
  const [left, top] = [Math.floor(x), Math.floor(y)];
  if (left < -1 || top < -1 || left >= width || top >= height) return 0;
  const [ax, ay] = [x - left, y - top];
  const valueAt = (i: number, j: number) =>
    i >= 0 && j >= 0 && i < width && j < height ? Number(pixels[j * width + i]) : 0;
  const upper = (1 - ax) * valueAt(left, top) + ax * valueAt(left + 1, top);
  const lower = (1 - ax) * valueAt(left, top + 1) + ax * valueAt(left + 1, top + 1);
  return (1 - ay) * upper + ay * lower;
}

/** Returns the mean difference of red, green and blue at two places. */
function compareColours(from: Picture, a: [number, number], to: Picture, b: [number, number]) {
  const [p, q] = [findPixel(from, a), findPixel(to, b)];
  const channelDifference = (c: number) => Math.abs(Number(from.data[p + c]) - Number(to.data[q + c]));
  return (channelDifference(0) + channelDifference(1) + channelDifference(2)) / 3;
}

function findPixel({ width, height }: Picture, [x, y]: [number, number]) {
  const column = Math.min(width - 1, Math.max(0, Math.round(x)));
  const row = Math.min(height - 1, Math.max(0, Math.round(y)));
  return 4 * (row * width + column);
}
