// Regions of a frame: the pixels under strokes, and pieces of objects.

import { TraceCutError, checkWholeNumber, illegal } from '../../check/errors.js';
import { strokeDistances } from '../../decoder.js';
import { platform } from '../../platform.js';
import { type Place, type Stroke, checkStroke } from '../../session/requests.js';
import { type Runs as Region, encodeRuns } from '../../session/serialize.js';
import { callDecoder } from '../../worker/instance.js';
import { type Mask, fillPiece } from './adjust.js';
import type { WasmSource } from '../../check/options.js';

/** Largest coordinate and radius of a stroke; sessions have the same limit. */
const MAX_STROKE_PX = 1e6;

/**
 * Measures a stroke in its frame, as sessions do: returns for each pixel the squared distance to the stroke's line,
 * Infinity beyond `reach`.
 * @param reach in pixels; the radius of the brush if not given
 */
async function measureStroke(
  stroke: Stroke,
  name: string,
  { width, height, numFrames }: { width: number; height: number; numFrames: number },
  decoder?: WasmSource,
  reach?: number,
): Promise<Float64Array> {
  const points = Float32Array.from(checkStroke(stroke, name, numFrames));
  const { radius } = stroke;
  const badIndex = points.findIndex((value) => !(Math.abs(value) <= MAX_STROKE_PX));
  if (!(radius >= 0 && radius <= MAX_STROKE_PX))
    throw illegal('param', `${name}.radius`, radius, `pixels, 0..=${MAX_STROKE_PX}`);
  if (points.length === 0) throw illegal('param', `${name}.points`, stroke.points, 'x0, y0, x1, y1, …');
  if (badIndex >= 0)
    throw illegal('param', `${name}.points[${badIndex}]`, points[badIndex], `pixels, up to ${MAX_STROKE_PX}`);
  // A brush that is thinner than a pixel still covers the pixel under it.
  const maxDistance = reach ?? Math.max(radius, Math.SQRT1_2);
  const module = await platform.loadDecoder(decoder);
  return callDecoder(module, () => strokeDistances(points, maxDistance, width, height), 'a stroke cannot be measured');
}

/** Marks the pixels that a round brush covers: all within its radius of its line. */
export async function strokePixels(
  stroke: Stroke,
  name: string,
  masks: { width: number; height: number; numFrames: number },
  decoder?: WasmSource,
): Promise<Uint8Array<ArrayBuffer>> {
  return Uint8Array.from(await measureStroke(stroke, name, masks, decoder), (square) => Number(square < Infinity));
}

/**
 * Returns the piece of a mask at a place: the connected pixels of one label, which touch at a side or a corner.
 * @param place in pixels of the mask
 */
export function findPiece(mask: Mask, { x, y }: Place): Region {
  const { width, height } = mask;
  const column = checkWholeNumber('param', 'at.x', Math.round(x), 0, width - 1);
  const row = checkWholeNumber('param', 'at.y', Math.round(y), 0, height - 1);
  const visited = new Uint8Array(width * height);
  fillPiece(mask, row * width + column, visited, new Uint32Array(width * height));
  return encodeRuns(visited);
}

/**
 * Divides the object with most pixels under the strokes: each of its pixels goes to the nearest stroke.
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
  const squaresByStroke: Float64Array[] = [];
  for (const [k, stroke] of strokes.entries()) {
    const pixels = await strokePixels(stroke, `strokes[${k}]`, masks, decoder);
    pixels.forEach((inside, p) => (covered[Number(labels[p])] = Number(covered[Number(labels[p])]) + inside));
    squaresByStroke.push(await measureStroke(stroke, `strokes[${k}]`, masks, decoder, masks.width + masks.height));
  }
  const label = covered.reduce(
    (best, count, candidate) => (candidate > 0 && count > Number(covered[best]) ? candidate : best),
    1,
  );
  if (covered[label] === 0) throw new TraceCutError('param', 'the strokes lie on no object of this frame');
  const nearest = labels.map((pixelLabel, p) => {
    if (pixelLabel !== label) return 0;
    return (
      squaresByStroke.reduce(
        (best, squares, k) => (Number(squares[p]) < Number(squaresByStroke[best]?.[p]) ? k : best),
        0,
      ) + 1
    );
  });
  return { label, regions: strokes.map((_, k) => encodeRuns(nearest.map((stroke) => Number(stroke === k + 1)))) };
}
