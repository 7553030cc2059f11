/**
 * What the drawing helpers share. Their unit is one pixel of the input and their origin the upper left corner of the
 * first one, as a canvas has it: on a canvas of the frame's size a helper draws where `drawImage(frame, 0, 0)` does.
 * Positions in results are those of pixel centres, whole numbers for pixels themselves; {@link onPixelCentres} is the
 * one place where that half pixel is added.
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

export type Scratch = CanvasImageSource & { width: number; height: number };

/**
 * Scales a context so that a frame fills its canvas: the transform that the drawing helpers want on a canvas that is
 * not of the frame's size. Replaces the context's transform.
 * @param frame a result, or any object that has its size in pixels
 * @returns how many pixels of the frame one of the canvas covers: a line width times this looks the same at every size
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

/** Draws and leaves the context's settings as they were. */
export function asideFrom(context: Context2D, draw: () => void) {
  if (typeof context?.save !== 'function' || typeof context.drawImage !== 'function')
    throw illegal('param', 'context', context, 'a 2D canvas context');
  context.save();
  try {
    draw();
  } finally {
    context.restore();
  }
}

/** As `asideFrom`, with the origin in the centre of the first pixel. */
export function onPixelCentres(context: Context2D, draw: () => void) {
  asideFrom(context, () => {
    context.translate(0.5, 0.5);
    draw();
  });
}

/**
 * A canvas to paint pixels on: where there is no `OffscreenCanvas`, one of the same make as the context's own.
 * @param read whether its pixels are to be read
 */
export function scratch(
  context: Context2D,
  width: number,
  height: number,
  read = false,
): { canvas: Scratch; context: Context2D } {
  const canvas = emptyCanvas(context, width, height);
  const own = canvas.getContext('2d', read ? { willReadFrequently: true } : {}) as Context2D | null;
  if (!own) throw new TraceCutError('unsupported', `there is no 2D canvas of ${width} × ${height} pixels to paint on`);
  return { canvas: canvas as Scratch, context: own };
}

function emptyCanvas(
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
      'this engine has no OffscreenCanvas to paint on, and the canvas given makes no others',
      { cause },
    );
  }
}

/**
 * Paints pixels aside.
 * @param paint fills red, green, blue and alpha, byte by byte, or pixel by pixel with colours as `pack` makes them
 */
export function painted(
  context: Context2D,
  width: number,
  height: number,
  paint: (data: Uint8ClampedArray, packed: Uint32Array) => void,
): Scratch {
  const aside = scratch(context, width, height);
  const image = aside.context.createImageData(width, height);
  paint(image.data, new Uint32Array(image.data.buffer, image.data.byteOffset, width * height));
  aside.context.putImageData(image, 0, 0);
  return aside.canvas;
}

/**
 * A colour as four bytes in memory order.
 * @param alpha 255 if not given
 */
export function pack([r = 0, g = 0, b = 0]: readonly number[], alpha = 255) {
  return Number(new Uint32Array(new Uint8ClampedArray([r, g, b, alpha]).buffer)[0]);
}

// Outlines of labelled regions by marching squares: straight lines between the middles of neighbouring pixels of
// different labels, so that stairs become slopes. They stay open along the rim.

/** Middles of the sides of a square between four pixel centres, clockwise from the upper one. */
const MIDDLES = [
  [0.5, 0],
  [1, 0.5],
  [0.5, 1],
  [0, 0.5],
] as const;

/**
 * @param labels row by row
 * @param chosen 1 for each label that is to have an outline
 * @returns for each label its pieces, each as x0, y0, x1, y1; pixel centres have whole coordinates
 */
export function outlines(labels: Uint8Array, width: number, height: number, chosen: Uint8Array): Map<number, number[]> {
  const pieces = new Map<number, number[]>();
  for (let y = 0; y + 1 < height; y += 1) {
    for (let x = 0; x + 1 < width; x += 1) {
      const at = y * width + x;
      const a = Number(labels[at]);
      const b = Number(labels[at + 1]);
      const c = Number(labels[at + width + 1]);
      const d = Number(labels[at + width]);
      if (a === b && b === c && c === d) continue;
      const corners = [a, b, c, d];
      corners.forEach((own, k) => {
        if (!chosen[own] || corners.indexOf(own) !== k) return;
        const known = pieces.get(own) ?? [];
        pieces.set(own, known);
        addSquare(
          known,
          x,
          y,
          corners.map((other) => other === own),
        );
      });
    }
  }
  return pieces;
}

/**
 * @param x of the upper left pixel
 * @param inside clockwise from the upper left
 */
function addSquare(pieces: number[], x: number, y: number, inside: boolean[]) {
  const crossed = [0, 1, 2, 3].filter((side) => inside[side] !== inside[(side + 1) % 4]);
  // Where two opposite corners are inside, each is cut off from the other.
  if (crossed.length === 4 && !inside[0]) crossed.push(Number(crossed.shift()));
  for (let k = 0; k < crossed.length; k += 2) {
    const [from, to] = crossed.length === 4 ? [crossed[(k + 3) % 4], crossed[k]] : crossed;
    const [[x0, y0], [x1, y1]] = [MIDDLES[Number(from)] ?? MIDDLES[0], MIDDLES[Number(to)] ?? MIDDLES[0]];
    pieces.push(x + x0, y + y0, x + x1, y + y1);
  }
}

/** Strokes pieces of lines in one go. */
export function strokePieces(context: Context2D, pieces: ArrayLike<number>) {
  context.beginPath();
  for (let k = 0; k < pieces.length; k += 4) {
    context.moveTo(Number(pieces[k]), Number(pieces[k + 1]));
    context.lineTo(Number(pieces[k + 2]), Number(pieces[k + 3]));
  }
  context.stroke();
}
