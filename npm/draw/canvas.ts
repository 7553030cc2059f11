/**
 * Canvas helpers shared by the drawing functions. Their unit is one pixel of the input and their origin the upper left
 * corner of the first pixel, as on a canvas: on a canvas of the frame's size a helper draws where
 * `drawImage(frame, 0, 0)` does. Positions in results refer to pixel centres, with whole numbers for pixels themselves;
 * {@link drawOnPixelCentres} is the one place where that half pixel is added.
 */

import { TraceCutError, illegal } from '../check/errors.js';

/** Any 2D canvas context: of a canvas element, of an `OffscreenCanvas`, or of a canvas library. */
export type Context2D = Pick<
  CanvasRenderingContext2D,
  | 'save'
  | 'restore'
  | 'translate'
  | 'scale'
  | 'beginPath'
  | 'closePath'
  | 'moveTo'
  | 'lineTo'
  | 'rect'
  | 'arc'
  | 'fill'
  | 'fillRect'
  | 'stroke'
  | 'drawImage'
  | 'createImageData'
  | 'putImageData'
  | 'getImageData'
  | 'fillStyle'
  | 'strokeStyle'
  | 'lineWidth'
  | 'lineCap'
  | 'globalAlpha'
  | 'globalCompositeOperation'
  | 'imageSmoothingEnabled'
> & { readonly canvas: { width: number; height: number } };

type Scratch = CanvasImageSource & { width: number; height: number };

/**
 * Scales a context so that a frame fills its canvas: the transform that the drawing helpers need on a canvas that is not
 * of the frame's size. Replaces the context's transform.
 * @param frame a result, or any object that has its size in pixels
 * @returns pixels of the frame per pixel of the canvas: a line width times this looks the same at every size
 */
export function fitFrame(
  context: Pick<CanvasRenderingContext2D, 'setTransform'> & { readonly canvas: { width: number; height: number } },
  frame: { width: number; height: number },
): number {
  const [x, y] = [context.canvas.width / frame.width, context.canvas.height / frame.height];
  if (!(x > 0 && y > 0 && Number.isFinite(x * y)))
    throw illegal('param', 'frame', frame, 'an object {width, height} in pixels, and a canvas that is not empty');
  context.setTransform(x, 0, 0, y, 0, 0);
  return 1 / Math.sqrt(x * y);
}

/** Calls `draw` and restores the context's state. */
export function withSavedState(context: Context2D, draw: () => void) {
  if (typeof context?.save !== 'function' || typeof context.drawImage !== 'function')
    throw illegal('param', 'context', context, 'a 2D canvas context');
  context.save();
  try {
    draw();
  } finally {
    context.restore();
  }
}

/** Draws as `withSavedState`, with the origin in the centre of the first pixel. */
export function drawOnPixelCentres(context: Context2D, draw: () => void) {
  withSavedState(context, () => {
    context.translate(0.5, 0.5);
    draw();
  });
}

/**
 * Creates a canvas to paint on, of the same class as the context's own if there is no `OffscreenCanvas`.
 * @param read true if its pixels will be read
 */
export function createScratch(
  context: Context2D,
  width: number,
  height: number,
  read = false,
): { canvas: Scratch; context: Context2D } {
  const canvas = createCanvas(context, width, height);
  const scratchContext = canvas.getContext('2d', read ? { willReadFrequently: true } : {}) as Context2D | null;
  if (!scratchContext)
    throw new TraceCutError('unsupported', `cannot create a 2D canvas of ${width} × ${height} pixels`);
  return { canvas: canvas as Scratch, context: scratchContext };
}

function createCanvas(
  { canvas }: Context2D,
  width: number,
  height: number,
): { getContext: (kind: '2d', options?: object) => unknown } {
  if (typeof OffscreenCanvas !== 'undefined') return new OffscreenCanvas(width, height);
  if (typeof document !== 'undefined') return Object.assign(document.createElement('canvas'), { width, height });
  const Canvas = canvas?.constructor as new (width: number, height: number) => { getContext: (kind: '2d') => unknown };
  try {
    return new Canvas(width, height);
  } catch (cause) {
    throw new TraceCutError(
      'unsupported',
      'this engine has no OffscreenCanvas, and the given canvas cannot create another',
      { cause },
    );
  }
}

/**
 * Paints pixels on a canvas of their own.
 * @param paint fills red, green, blue and alpha, byte by byte, or pixel by pixel with colours packed by `packColor`
 */
export function paintPixels(
  context: Context2D,
  width: number,
  height: number,
  paint: (data: Uint8ClampedArray, packed: Uint32Array) => void,
): Scratch {
  const target = createScratch(context, width, height);
  const image = target.context.createImageData(width, height);
  paint(image.data, new Uint32Array(image.data.buffer, image.data.byteOffset, width * height));
  target.context.putImageData(image, 0, 0);
  return target.canvas;
}

/**
 * Packs a colour into four bytes in memory order.
 * @param alpha 255 if not given
 */
export function packColor([r = 0, g = 0, b = 0]: readonly number[], alpha = 255) {
  return Number(new Uint32Array(new Uint8ClampedArray([r, g, b, alpha]).buffer)[0]);
}

// Outlines of labelled regions by marching squares: straight segments between the middles of neighbouring pixels of
// different labels, so that stairs become slopes. Outlines stay open along the frame border.

/** Middles of the sides of a square between four pixel centres, clockwise from the top. */
const SIDE_MIDDLES = [
  [0.5, 0],
  [1, 0.5],
  [0.5, 1],
  [0, 0.5],
] as const;

/**
 * Traces the outlines of labels.
 * @param labels row by row
 * @param selected 1 for each label that gets an outline
 * @returns for each label its segments, each as x0, y0, x1, y1; pixel centres have whole coordinates
 */
export function traceOutlines(
  labels: Uint8Array,
  width: number,
  height: number,
  selected: Uint8Array,
): Map<number, number[]> {
  const segmentsByLabel = new Map<number, number[]>();
  for (let y = 0; y + 1 < height; y += 1) {
    for (let x = 0; x + 1 < width; x += 1) {
      const index = y * width + x;
      const a = Number(labels[index]);
      const b = Number(labels[index + 1]);
      const c = Number(labels[index + width + 1]);
      const d = Number(labels[index + width]);
      if (a === b && b === c && c === d) continue;
      const corners = [a, b, c, d];
      corners.forEach((label, k) => {
        if (!selected[label] || corners.indexOf(label) !== k) return;
        const segments = segmentsByLabel.get(label) ?? [];
        segmentsByLabel.set(label, segments);
        addSquare(
          segments,
          x,
          y,
          corners.map((corner) => corner === label),
        );
      });
    }
  }
  return segmentsByLabel;
}

/**
 * @param x of the upper left pixel
 * @param inside clockwise from the upper left
 */
function addSquare(segments: number[], x: number, y: number, inside: boolean[]) {
  const crossedSides = [0, 1, 2, 3].filter((side) => inside[side] !== inside[(side + 1) % 4]);
  // Where two opposite corners are inside, each is cut off from the other.
  if (crossedSides.length === 4 && !inside[0]) crossedSides.push(Number(crossedSides.shift()));
  for (let k = 0; k < crossedSides.length; k += 2) {
    const [from, to] = crossedSides.length === 4 ? [crossedSides[(k + 3) % 4], crossedSides[k]] : crossedSides;
    const [[x0, y0], [x1, y1]] = [
      SIDE_MIDDLES[Number(from)] ?? SIDE_MIDDLES[0],
      SIDE_MIDDLES[Number(to)] ?? SIDE_MIDDLES[0],
    ];
    segments.push(x + x0, y + y0, x + x1, y + y1);
  }
}

/** Strokes line segments in one path. */
export function strokeSegments(context: Context2D, segments: ArrayLike<number>) {
  context.beginPath();
  for (let k = 0; k < segments.length; k += 4) {
    context.moveTo(Number(segments[k]), Number(segments[k + 1]));
    context.lineTo(Number(segments[k + 2]), Number(segments[k + 3]));
  }
  context.stroke();
}
