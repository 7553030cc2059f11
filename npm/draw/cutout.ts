// Objects cut out of their frame, on another backdrop.

import { checkOptions, illegal } from '../check/errors.js';
import { type Context2D, createScratch, withSavedState } from './canvas.js';

/**
 * A backdrop of cut-out objects: `transparent` for none; their own frame, `blurred`, `desaturated` (without colour) or
 * `dimmed` (dark, as around a spotlight); any CSS colour; or a picture, which fills the frame and is cropped to its
 * shape.
 */
export type Backdrop = string | (CanvasImageSource & { width: number; height: number });

/** Opacity of the objects at each pixel, row by row, 0 to 255. */
export type CutoutMask = { width: number; height: number; alpha: Uint8Array };

/** Options of `drawCutout`. */
export interface DrawCutoutOptions {
  /** The backdrop; `transparent` if not given. */
  background?: Backdrop;
}

/** Pixels of a frame of at most 480 pixels that are averaged to one before it is enlarged again; chosen by eye. */
const BLUR_PX = 16;
/** Brightness of a dimmed frame, of 1; chosen by eye. */
const DIMMED_BRIGHTNESS = 0.35;
/** Backdrops made from the frame itself. */
const FRAME_BACKDROPS = ['blurred', 'desaturated', 'dimmed'];
/** Legal backdrops, for messages. */
export const LEGAL_BACKDROPS = "'transparent', 'blurred', 'desaturated', 'dimmed', a CSS colour or a picture";

/**
 * Draws the objects of a frame alone, on a backdrop. The context's unit is one pixel of the mask, its origin the frame's
 * upper left corner (see `fitFrame`).
 * @param frame of any size: it is scaled to the mask
 */
export function drawCutout(
  context: Context2D,
  frame: CanvasImageSource,
  mask: CutoutMask,
  options: DrawCutoutOptions = {},
) {
  const { background = 'transparent' } = checkOptions(options, ['background']);
  checkMask(mask);
  withSavedState(context, () => {
    drawBackdrop(context, frame, mask, background);
    const cutout = cutOut(context, frame, mask);
    if (cutout) context.drawImage(cutout.picture, cutout.x, cutout.y);
  });
}

/**
 * Cuts the objects out of a frame.
 * @param context any: the picture is a canvas of the same class
 * @param frame of any size: it is scaled to the mask
 * @returns the objects and the place of their box in the mask; null if there are none
 */
function cutOut(
  context: Context2D,
  frame: CanvasImageSource,
  mask: CutoutMask,
): { picture: CanvasImageSource; x: number; y: number } | null {
  const { width: fullWidth, height: fullHeight, alpha } = mask;
  const box = findBox(alpha, fullWidth, fullHeight);
  if (!box) return null;
  const { x, y, width, height } = box;
  const target = createScratch(context, width, height);
  const shape = target.context.createImageData(width, height);
  for (let p = 0; p < width * height; p += 1)
    shape.data[4 * p + 3] = Number(alpha[(y + Math.floor(p / width)) * fullWidth + x + (p % width)]);
  target.context.putImageData(shape, 0, 0);
  target.context.globalCompositeOperation = 'source-in';
  target.context.drawImage(frame, -x, -y, fullWidth, fullHeight);
  return { picture: target.canvas, x, y };
}

/**
 * Finds the box around all pixels that are not clear; null if all are.
 * @param alpha row by row
 */
export function findBox(
  alpha: Uint8Array,
  width: number,
  height: number,
): { x: number; y: number; width: number; height: number } | null {
  let [first, last] = [0, width * height - 1];
  while (first <= last && alpha[first] === 0) first += 1;
  if (first > last) return null;
  while (alpha[last] === 0) last -= 1;
  const [top, bottom] = [Math.floor(first / width), Math.floor(last / width)];
  let [left, right] = [width, -1];
  // Only what may still widen the box is read.
  for (let y = top, row = top * width; y <= bottom; y += 1, row += width) {
    for (let x = 0; x < left; x += 1) if (alpha[row + x] !== 0) left = x;
    for (let x = width - 1; x > right; x -= 1) if (alpha[row + x] !== 0) right = x;
  }
  return { x: left, y: top, width: right - left + 1, height: bottom - top + 1 };
}

function checkMask(mask: CutoutMask) {
  const { width, height, alpha } = mask ?? {};
  if (!(alpha instanceof Uint8Array) || !(width > 0) || alpha.length !== width * height)
    throw illegal('data', 'mask', mask, 'an object {width, height, alpha} with a byte for each pixel');
}

export function drawBackdrop(
  context: Context2D,
  frame: CanvasImageSource,
  { width, height }: { width: number; height: number },
  background: Backdrop,
) {
  if (background === 'transparent') return;
  if (background === 'blurred') {
    drawBlurred(context, frame, width, height);
  } else if (background === 'desaturated' || background === 'dimmed') {
    context.drawImage(frame, 0, 0, width, height);
    // Blending a grey with the mode `saturation` removes all colour.
    if (background === 'desaturated') context.globalCompositeOperation = 'saturation';
    context.fillStyle = background === 'desaturated' ? '#808080' : `rgba(0, 0, 0, ${1 - DIMMED_BRIGHTNESS})`;
    context.fillRect(0, 0, width, height);
    context.globalCompositeOperation = 'source-over';
  } else if (typeof background === 'string') {
    context.fillStyle = background;
    context.fillRect(0, 0, width, height);
  } else {
    const scale = Math.min(background.width / width, background.height / height);
    const [w, h] = [width * scale, height * scale];
    context.drawImage(background, (background.width - w) / 2, (background.height - h) / 2, w, h, 0, 0, width, height);
  }
}

/** Reduces the frame step by step, then enlarges it: unlike a filter, all browsers can do it. */
function drawBlurred(context: Context2D, frame: CanvasImageSource, width: number, height: number) {
  const reduce = BLUR_PX * Math.max(1, Math.max(width, height) / 480);
  let picture: CanvasImageSource = frame;
  for (const part of [4, 2, 1, 2]) {
    const target = createScratch(context, Math.ceil((part * width) / reduce), Math.ceil((part * height) / reduce));
    target.context.imageSmoothingEnabled = true;
    target.context.drawImage(picture, 0, 0, target.canvas.width, target.canvas.height);
    picture = target.canvas;
  }
  context.imageSmoothingEnabled = true;
  context.drawImage(picture, 0, 0, width, height);
}

/** Returns true for a backdrop made from the frame. */
export function isFrameBackdrop(background: Backdrop) {
  return typeof background === 'string' && FRAME_BACKDROPS.includes(background);
}

/** Returns true for a name or a picture. Colours are not checked. */
export function isBackdrop(background: unknown): background is Backdrop {
  if (typeof background === 'string') return true;
  const { width, height } = (background ?? {}) as { width?: unknown; height?: unknown };
  return Number(width) > 0 && Number(height) > 0;
}
