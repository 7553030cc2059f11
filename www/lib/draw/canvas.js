/**
 * What the drawing helpers share. Their unit is one pixel of the input and their origin the upper left corner of the
 * first one, as a canvas has it: on a canvas of the frame's size a helper draws where `drawImage(frame, 0, 0)` does.
 * Positions in results are those of pixel centres, whole numbers for pixels themselves; {@link onPixelCentres} is the
 * one place where that half pixel is added.
 */

import { TraceCutError, illegal } from '../errors.js';

/**
 * Any 2D canvas context: of a canvas element, of an `OffscreenCanvas`, or of a canvas library.
 * @typedef {Pick<CanvasRenderingContext2D, 'save' | 'restore' | 'translate' | 'scale' | 'beginPath' | 'closePath'
 *   | 'moveTo' | 'lineTo' | 'rect'
 *   | 'arc' | 'fill' | 'fillRect' | 'stroke' | 'drawImage' | 'createImageData' | 'putImageData' | 'getImageData' | 'fillStyle' | 'strokeStyle' | 'lineWidth' | 'lineCap'
 *   | 'globalAlpha' | 'globalCompositeOperation' | 'imageSmoothingEnabled'> & {readonly canvas: {width: number, height: number}}} Context2D
 */

/** @typedef {CanvasImageSource & {width: number, height: number}} Scratch */

/**
 * Scales a context so that a frame fills its canvas: the transform that the drawing helpers want on a canvas that is
 * not of the frame's size. Replaces the context's transform.
 * @param {Pick<CanvasRenderingContext2D, 'setTransform'> & {readonly canvas: {width: number, height: number}}} context
 * @param {{width: number, height: number}} frame a result, or any object that has its size in pixels
 * @returns {number} how many pixels of the frame one of the canvas covers: a line width times this looks the same at
 *   every size
 */
export function fitFrame(context, frame) {
  const [x, y] = [context.canvas.width / frame.width, context.canvas.height / frame.height];
  if (!(x > 0 && y > 0 && Number.isFinite(x * y)))
    throw illegal('param', 'frame', frame, 'an object {width, height} in pixels, and a canvas that is not empty');
  context.setTransform(x, 0, 0, y, 0, 0);
  return 1 / Math.sqrt(x * y);
}

/**
 * Draws and leaves the context's settings as they were.
 * @param {Context2D} context
 * @param {() => void} draw
 */
export function asideFrom(context, draw) {
  if (typeof context?.save !== 'function' || typeof context.drawImage !== 'function')
    throw illegal('param', 'context', context, 'a 2D canvas context');
  context.save();
  try {
    draw();
  } finally {
    context.restore();
  }
}

/**
 * As `asideFrom`, with the origin in the centre of the first pixel.
 * @param {Context2D} context
 * @param {() => void} draw
 */
export function onPixelCentres(context, draw) {
  asideFrom(context, () => {
    context.translate(0.5, 0.5);
    draw();
  });
}

/**
 * A canvas to paint pixels on: where there is no `OffscreenCanvas`, one of the same make as the context's own.
 * @param {Context2D} context
 * @param {number} width
 * @param {number} height
 * @param {boolean} [read] whether its pixels are to be read
 * @returns {{canvas: Scratch, context: Context2D}}
 */
export function scratch(context, width, height, read = false) {
  const canvas = emptyCanvas(context, width, height);
  const own = /** @type {Context2D | null} */ (canvas.getContext('2d', read ? { willReadFrequently: true } : {}));
  if (!own) throw new TraceCutError('unsupported', `there is no 2D canvas of ${width} × ${height} pixels to paint on`);
  return { canvas: /** @type {Scratch} */ (/** @type {unknown} */ (canvas)), context: own };
}

/**
 * @param {Context2D} context
 * @param {number} width
 * @param {number} height
 * @returns {{getContext: (kind: '2d', options?: object) => unknown}}
 */
function emptyCanvas({ canvas }, width, height) {
  if (typeof OffscreenCanvas !== 'undefined') return new OffscreenCanvas(width, height);
  if (typeof document !== 'undefined') return Object.assign(document.createElement('canvas'), { width, height });
  const Canvas = /** @type {new (width: number, height: number) => {getContext: (kind: '2d') => unknown}} */ (
    canvas?.constructor
  );
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
 * @param {Context2D} context
 * @param {number} width
 * @param {number} height
 * @param {(data: Uint8ClampedArray, packed: Uint32Array) => void} paint fills red, green, blue and alpha, byte by byte,
 *   or pixel by pixel with colours as `pack` makes them
 * @returns {Scratch}
 */
export function painted(context, width, height, paint) {
  const aside = scratch(context, width, height);
  const image = aside.context.createImageData(width, height);
  paint(image.data, new Uint32Array(image.data.buffer, image.data.byteOffset, width * height));
  aside.context.putImageData(image, 0, 0);
  return aside.canvas;
}

/**
 * A colour as four bytes in memory order.
 * @param {readonly number[]} rgb
 * @param {number} [alpha] 255 if not given
 */
export function pack([r = 0, g = 0, b = 0], alpha = 255) {
  return Number(new Uint32Array(new Uint8ClampedArray([r, g, b, alpha]).buffer)[0]);
}
