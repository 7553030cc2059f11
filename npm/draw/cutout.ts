// Objects cut out of their frame, on another ground.

import { checkedOptions, illegal } from '../check/errors.js';
import { type Context2D, asideFrom, scratch } from './canvas.js';

/**
 * What cut-out objects lie on: `transparent`, nothing; their own frame, `blurred` (out of focus), `desaturated` (without
 * its colours) or `dimmed` (dark, as beside a spotlight); any CSS colour; or a picture, which fills the frame and is cut
 * where it has another shape.
 */
export type Ground = string | (CanvasImageSource & { width: number; height: number });

/** How opaque the objects are at each pixel, row by row, 0 to 255. */
export type CutoutMask = { width: number; height: number; alpha: Uint8Array };

/** How cut-out objects are drawn. */
export interface DrawCutoutOptions {
  /** What they lie on; `transparent` if not given. */
  background?: Ground;
}

/** Pixels of a frame that become one before it is enlarged again. */
const BLUR = 16;
/** What is left of the light of a frame that is dimmed. */
const DIMMED = 0.35;
/** Grounds that are made of the frame itself. */
const OF_FRAME = ['blurred', 'desaturated', 'dimmed'];
/** What a ground may be, in words. */
export const GROUNDS = "'transparent', 'blurred', 'desaturated', 'dimmed', a CSS colour or a picture";

/**
 * Draws the objects of a frame alone, on a ground. The context's unit is one pixel of the mask, its origin the frame's
 * upper left corner (see `fitFrame`).
 * @param frame of any size: it fills the mask's
 */
export function drawCutout(
  context: Context2D,
  frame: CanvasImageSource,
  mask: CutoutMask,
  options: DrawCutoutOptions = {},
) {
  const { background = 'transparent' } = checkedOptions(options, ['background']);
  checkMask(mask);
  asideFrom(context, () => {
    drawGround(context, frame, mask, background);
    const cutout = cutOut(context, frame, mask);
    if (cutout) context.drawImage(cutout.picture, cutout.x, cutout.y);
  });
}

/**
 * Cuts the objects out of a frame.
 * @param context any: the picture is of its make
 * @param frame of any size: it fills the mask's
 * @returns the objects in their box of the mask; null where there are none
 */
function cutOut(
  context: Context2D,
  frame: CanvasImageSource,
  mask: CutoutMask,
): { picture: CanvasImageSource; x: number; y: number } | null {
  const { width: across, height: down, alpha } = mask;
  const box = boxOf(alpha, across, down);
  if (!box) return null;
  const { x, y, width, height } = box;
  const aside = scratch(context, width, height);
  const shape = aside.context.createImageData(width, height);
  for (let p = 0; p < width * height; p += 1)
    shape.data[4 * p + 3] = Number(alpha[(y + Math.floor(p / width)) * across + x + (p % width)]);
  aside.context.putImageData(shape, 0, 0);
  aside.context.globalCompositeOperation = 'source-in';
  aside.context.drawImage(frame, -x, -y, across, down);
  return { picture: aside.canvas, x, y };
}

/**
 * @param alpha row by row
 * @param across pixels in a row
 * @param down rows
 * @returns what is not clear; null where all is
 */
export function boxOf(
  alpha: Uint8Array,
  across: number,
  down: number,
): { x: number; y: number; width: number; height: number } | null {
  let [left, right, top, bottom] = [across, -1, -1, -1];
  for (let y = 0, p = 0; y < down; y += 1) {
    for (let x = 0; x < across; x += 1, p += 1) {
      if (alpha[p] === 0) continue;
      if (x < left) left = x;
      if (x > right) right = x;
      if (top < 0) top = y;
      bottom = y;
    }
  }
  return right < 0 ? null : { x: left, y: top, width: right - left + 1, height: bottom - top + 1 };
}

function checkMask(mask: CutoutMask) {
  const { width, height, alpha } = mask ?? {};
  if (!(alpha instanceof Uint8Array) || !(width > 0) || alpha.length !== width * height)
    throw illegal('data', 'mask', mask, 'an object {width, height, alpha} with a byte for each pixel');
}

export function drawGround(
  context: Context2D,
  frame: CanvasImageSource,
  { width, height }: { width: number; height: number },
  background: Ground,
) {
  if (background === 'transparent') return;
  if (background === 'blurred') {
    drawBlurred(context, frame, width, height);
  } else if (background === 'desaturated' || background === 'dimmed') {
    context.drawImage(frame, 0, 0, width, height);
    // Grey has no saturation to give.
    if (background === 'desaturated') context.globalCompositeOperation = 'saturation';
    context.fillStyle = background === 'desaturated' ? '#808080' : `rgba(0, 0, 0, ${1 - DIMMED})`;
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

/** Made small step by step, then large again: unlike a filter, all browsers can do it. */
function drawBlurred(context: Context2D, frame: CanvasImageSource, width: number, height: number) {
  const reduce = BLUR * Math.max(1, Math.max(width, height) / 480);
  let picture: CanvasImageSource = frame;
  for (const part of [4, 2, 1, 2]) {
    const aside = scratch(context, Math.ceil((part * width) / reduce), Math.ceil((part * height) / reduce));
    aside.context.imageSmoothingEnabled = true;
    aside.context.drawImage(picture, 0, 0, aside.canvas.width, aside.canvas.height);
    picture = aside.canvas;
  }
  context.imageSmoothingEnabled = true;
  context.drawImage(picture, 0, 0, width, height);
}

/** Whether this names something that is made of the frame. */
export function isOfFrame(background: Ground) {
  return typeof background === 'string' && OF_FRAME.includes(background);
}

/** Whether this is a ground: a name, or a picture. Colours are not looked at. */
export function isGround(background: unknown): background is Ground {
  if (typeof background === 'string') return true;
  const { width, height } = (background ?? {}) as { width?: unknown; height?: unknown };
  return Number(width) > 0 && Number(height) > 0;
}
