// An edit of one frame carried to others: its region goes with the optical flow, from frame to frame, as long as the
// picture there looks like where it came from.

import { TraceCutError, checkNumber, illegal, isPlainObject, wholeNumber } from '../../check/errors.js';
import { createImageEngine } from '../../stages/image.js';
import { areaOf, pixelsOf } from './regions.js';

/** @typedef {import('./regions.js').Region} Region */
/**
 * The pixels of a frame: RGBA bytes, row by row.
 * @typedef {{data: Uint8Array | Uint8ClampedArray, width: number, height: number}} Picture
 */

/**
 * How an edit is carried.
 * @typedef {object} CarryOptions
 * @property {(t: number) => Picture | Promise<Picture>} picture gives a frame's pixels as RGBA bytes, at any size
 * @property {number} [first] where it ends at the latest on the way back; the shot's first frame, or the clip's, if
 *   not given
 * @property {number} [last] where it ends at the latest on the way on; the shot's last frame, or the clip's, if not
 *   given
 * @property {number} [leastEvidence] where it ends, 0 to 1: the share of the region that looks like what it came from;
 *   .6 if
 *   not given
 * @property {import('../../stages/image.js').ImageEngine} [engine] saves opening one for each edit
 * @property {AbortSignal} [signal] ends the work: the promise rejects with its reason
 * @property {(reached: {t: number, evidence: number}) => void} [onFrame] hears of each frame that was reached
 */

/** How far an edit was carried: the first and the last frame that have it. @typedef {{first: number, last: number}} Carried */

/** @typedef {(from: Picture, to: Picture) => Promise<import('../../session/engine.js').FlowField>} FlowBetween */

/** Colours that differ by less are the same, as the mean over red, green and blue. */
const SAME_COLOUR = 24;
/** A region that grows or shrinks by more from one frame to the next has lost its way. */
const MOST_CHANGE = 1.6;

/**
 * Carries a painted edit to the frames before and after it, as parts of the same edit.
 * @param {import('./editor.js').MaskEditor} editor
 * @param {import('./editor.js').Edit} edit as `paint` gave it, in force
 * @param {CarryOptions} options
 * @param {FlowBetween} flow
 * @returns {Promise<Carried>}
 */
export async function carry(editor, edit, options, flow) {
  const { picture, first, last, least, signal, onFrame } = checked(editor, edit, options);
  const start = /** @type {number} */ ([...(edit.parts?.keys() ?? [])][0]);
  const reached = { first: start, last: start };
  for (const step of [1, -1]) {
    const begun = /** @type {import('./editor.js').Part} */ (edit.parts?.get(start));
    let { region } = begun;
    let before = checkedPicture(await picture(start), start);
    for (let t = start + step; t >= first && t <= last; t += step) {
      signal?.throwIfAborted();
      const now = checkedPicture(await picture(t), t);
      const moved = move(region, await flow(now, before), [before, now], editor);
      signal?.throwIfAborted();
      if (moved.evidence < least) break;
      ({ region } = moved);
      editor.extend(edit, t, region, moved.evidence);
      reached[step > 0 ? 'last' : 'first'] = t;
      onFrame?.({ t, evidence: moved.evidence });
      before = now;
    }
  }
  return reached;
}

/**
 * Carries a painted edit to the frames before and after it, as parts of the same edit: its region goes with the optical
 * flow from frame to frame, within the shot, as long as the picture there looks like what it came from.
 *
 * ```js
 * const { first, last } = await carryEdit(editor, edit, { picture: (t) => frames[t] });
 * ```
 * @param {import('./editor.js').MaskEditor} editor
 * @param {import('./editor.js').Edit} edit as `paint` gave it, in force
 * @param {CarryOptions} options
 * @returns {Promise<Carried>}
 */
export async function carryEdit(editor, edit, options) {
  checked(editor, edit, options);
  const engine = options.engine ?? (await createImageEngine());
  try {
    return await carry(editor, edit, options, (from, to) => engine.flow(from, to));
  } finally {
    if (!options.engine) engine.close();
  }
}

/**
 * @param {import('./editor.js').MaskEditor} editor
 * @param {import('./editor.js').Edit} edit
 * @param {CarryOptions} options
 */
function checked(editor, edit, options) {
  if (!isPlainObject(options) || typeof options.picture !== 'function')
    throw illegal('param', 'options.picture', options?.picture, 'a function that gives the pixels of frame t');
  if (!edit?.parts?.size) throw illegal('param', 'edit', edit, 'an edit as paint gave it');
  const start = /** @type {number} */ ([...edit.parts.keys()][0]);
  // What is beyond a cut is another scene.
  const shot = editor.shots?.find(({ first, last }) => first <= start && start <= last);
  const { picture, first = shot?.first ?? 0, last = shot?.last ?? editor.numFrames - 1, leastEvidence = 0.6 } = options;
  wholeNumber('param', 'first', first, 0, start);
  wholeNumber('param', 'last', last, start, editor.numFrames - 1);
  checkNumber('leastEvidence', leastEvidence, 0, 1);
  return { picture, first, last, least: leastEvidence, signal: options.signal, onFrame: options.onFrame };
}

/**
 * @param {Picture} picture
 * @param {number} t
 */
function checkedPicture(picture, t) {
  const { data, width, height } = picture ?? {};
  if (!data || data.length !== 4 * width * height)
    throw new TraceCutError('data', `picture(${t}) is no {data, width, height} of RGBA bytes`);
  return picture;
}

/**
 * Where a region is in the next frame. Each pixel there looks back along the flow: it belongs to the region if most of
 * what it came from does.
 * @param {Region} region
 * @param {import('../../session/engine.js').FlowField} back from each pixel of the next picture to this one, in its pixels
 * @param {[Picture, Picture]} pictures this and the next, of one size
 * @param {{width: number, height: number}} masks
 * @returns {{region: Region, evidence: number}}
 */
export function move(region, back, [from, to], { width, height }) {
  const before = pixelsOf(region, width * height);
  const [sx, sy] = [back.width / width, back.height / height];
  /** @type {number[]} */
  const runs = [];
  let [alike, count] = [0, 0];
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const fx = Math.min(back.width - 1, Math.floor((x + 0.5) * sx));
      const fy = Math.min(back.height - 1, Math.floor((y + 0.5) * sy));
      const f = fy * back.width + fx;
      const [u, v] = [Number(back.u[f]), Number(back.v[f])];
      const [px, py] = [x + u / sx, y + v / sy];
      if (share(before, width, height, px, py) < 0.5) continue;
      const p = y * width + x;
      if (runs.length > 0 && Number(runs[runs.length - 2]) + Number(runs[runs.length - 1]) === p)
        runs[runs.length - 1] = Number(runs[runs.length - 1]) + 1;
      else runs.push(p, 1);
      count += 1;
      alike += Number(difference(from, [fx + u, fy + v], to, [fx, fy]) < SAME_COLOUR);
    }
  }
  const change = count / Math.max(1, areaOf(region));
  const kept = count > 0 && change < MOST_CHANGE && change > 1 / MOST_CHANGE;
  return { region: Uint32Array.from(runs), evidence: kept ? alike / count : 0 };
}

/**
 * How much of the pixel at a place between pixels is set, 0 to 1; nothing is beyond the frame.
 * @param {Uint8Array} pixels
 * @param {number} width
 * @param {number} height
 * @param {number} x
 * @param {number} y
 */
function share(pixels, width, height, x, y) {
  const [left, top] = [Math.floor(x), Math.floor(y)];
  if (left < -1 || top < -1 || left >= width || top >= height) return 0;
  const [ax, ay] = [x - left, y - top];
  const one = (/** @type {number} */ i, /** @type {number} */ j) =>
    i >= 0 && j >= 0 && i < width && j < height ? Number(pixels[j * width + i]) : 0;
  const upper = (1 - ax) * one(left, top) + ax * one(left + 1, top);
  const lower = (1 - ax) * one(left, top + 1) + ax * one(left + 1, top + 1);
  return (1 - ay) * upper + ay * lower;
}

/**
 * How far the colours at two places are apart, as the mean over red, green and blue.
 * @param {Picture} from
 * @param {[number, number]} a
 * @param {Picture} to
 * @param {[number, number]} b
 */
function difference(from, a, to, b) {
  const [p, q] = [pixelAt(from, a), pixelAt(to, b)];
  const of = (/** @type {number} */ c) => Math.abs(Number(from.data[p + c]) - Number(to.data[q + c]));
  return (of(0) + of(1) + of(2)) / 3;
}

/**
 * @param {Picture} picture
 * @param {[number, number]} place
 */
function pixelAt({ width, height }, [x, y]) {
  const column = Math.min(width - 1, Math.max(0, Math.round(x)));
  const row = Math.min(height - 1, Math.max(0, Math.round(y)));
  return 4 * (row * width + column);
}
