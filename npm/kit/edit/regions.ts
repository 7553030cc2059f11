// Regions of a frame: what strokes cover, and pieces of objects.

import { TraceCutError, illegal, wholeNumber } from '../../check/errors.js';
import { strokeDistances } from '../../decoder.js';
import { platform } from '../../platform.js';
import { type Place, type Stroke, strokePoints } from '../../session/inputs.js';
import { type Runs as Region, encodeRuns } from '../../session/runs.js';
import { callDecoder } from '../../worker/decode.js';
import { type Mask, fillPiece } from './adjust.js';
import type { WasmSource } from '../../check/options.js';

/** Largest coordinate and radius of a stroke in pixels; sessions know the same. */
const FARTHEST = 1e6;

/**
 * Measures a stroke in its frame, as sessions do: for each pixel the square of its distance to the stroke's way,
 * Infinity beyond `reach`.
 * @param reach in pixels; the radius of the brush if not given
 */
async function distances(
  stroke: Stroke,
  name: string,
  { width, height, numFrames }: { width: number; height: number; numFrames: number },
  decoder?: WasmSource,
  reach?: number,
): Promise<Float64Array> {
  const points = Float32Array.from(strokePoints(stroke, name, numFrames));
  const { radius } = stroke;
  const wrong = points.findIndex((value) => !(Math.abs(value) <= FARTHEST));
  if (!(radius >= 0 && radius <= FARTHEST)) throw illegal('param', `${name}.radius`, radius, `pixels, 0..=${FARTHEST}`);
  if (points.length === 0) throw illegal('param', `${name}.points`, stroke.points, 'x0, y0, x1, y1, …');
  if (wrong >= 0) throw illegal('param', `${name}.points[${wrong}]`, points[wrong], `pixels, up to ${FARTHEST}`);
  // A brush that is thinner than a pixel still covers the pixel that it is in.
  const far = reach ?? Math.max(radius, Math.SQRT1_2);
  const module = await platform.loadDecoder(decoder);
  return callDecoder(module, () => strokeDistances(points, far, width, height), 'a stroke cannot be measured');
}

/** Marks the pixels that a round brush covers: all within its radius of its way. */
export async function strokePixels(
  stroke: Stroke,
  name: string,
  masks: { width: number; height: number; numFrames: number },
  decoder?: WasmSource,
): Promise<Uint8Array<ArrayBuffer>> {
  return Uint8Array.from(await distances(stroke, name, masks, decoder), (square) => Number(square < Infinity));
}

/**
 * Returns the piece of a mask at a place: all pixels of that label which hang together with it, at a side or a corner.
 * @param place in pixels of the mask
 */
export function pieceRegion(mask: Mask, { x, y }: Place): Region {
  const { width, height } = mask;
  const column = wholeNumber('param', 'at.x', Math.round(x), 0, width - 1);
  const row = wholeNumber('param', 'at.y', Math.round(y), 0, height - 1);
  const seen = new Uint8Array(width * height);
  fillPiece(mask, row * width + column, seen, new Uint32Array(width * height));
  return encodeRuns(seen);
}

/**
 * Divides the object that strokes lie on most among them: each of its pixels goes to the nearest stroke.
 * @param strokes two or more in this frame
 * @returns a region for each stroke
 */
export async function divideRegions(
  labels: Uint8Array,
  strokes: readonly Stroke[],
  masks: { width: number; height: number; numFrames: number },
  decoder?: WasmSource,
): Promise<{ label: number; regions: Region[] }> {
  const covered = new Uint32Array(256);
  const away: Float64Array[] = [];
  for (const [k, stroke] of strokes.entries()) {
    const pixels = await strokePixels(stroke, `strokes[${k}]`, masks, decoder);
    pixels.forEach((inside, p) => (covered[Number(labels[p])] = Number(covered[Number(labels[p])]) + inside));
    away.push(await distances(stroke, `strokes[${k}]`, masks, decoder, masks.width + masks.height));
  }
  const label = covered.reduce((best, count, one) => (one > 0 && count > Number(covered[best]) ? one : best), 1);
  if (covered[label] === 0) throw new TraceCutError('param', 'the strokes lie on no object of this frame');
  const nearest = labels.map((one, p) => {
    if (one !== label) return 0;
    return away.reduce((best, squares, k) => (Number(squares[p]) < Number(away[best]?.[p]) ? k : best), 0) + 1;
  });
  return { label, regions: strokes.map((_, k) => encodeRuns(nearest.map((one) => Number(one === k + 1)))) };
}
