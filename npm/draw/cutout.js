// Objects cut out of their frame, on another ground.

import { checkedOptions, illegal } from '../check/errors.js';
import { asideFrom, scratch } from './canvas.js';

/**
 * What cut-out objects lie on: `transparent`, nothing; their own frame, `blurred` (out of focus), `desaturated` (without
 * its colours) or `dimmed` (dark, as beside a spotlight); any CSS colour; or a picture, which fills the frame and is cut
 * where it has another shape.
 * @typedef {string | (CanvasImageSource & {width: number, height: number})} Ground
 */

/**
 * How opaque the objects are at each pixel, row by row, 0 to 255. @typedef {{width: number, height: number, alpha:
 * Uint8Array}} CutoutMask
 */

/**
 * How cut-out objects are drawn.
 * @typedef {object} DrawCutoutOptions
 * @property {Ground} [background] what they lie on; `transparent` if not given
 */

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
 * @param {import('./canvas.js').Context2D} context
 * @param {CanvasImageSource} frame of any size: it fills the mask's
 * @param {CutoutMask} mask
 * @param {DrawCutoutOptions} [options]
 */
export function drawCutout(context, frame, mask, options = {}) {
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
 * @param {import('./canvas.js').Context2D} context any: the picture is of its make
 * @param {CanvasImageSource} frame of any size: it fills the mask's
 * @param {CutoutMask} mask
 * @returns {{picture: CanvasImageSource, x: number, y: number} | null} the objects in their box of the mask; null where
 *   there are none
 */
function cutOut(context, frame, mask) {
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
 * @param {Uint8Array} alpha row by row
 * @param {number} across pixels in a row
 * @param {number} down rows
 * @returns {{x: number, y: number, width: number, height: number} | null} what is not clear; null where all is
 */
export function boxOf(alpha, across, down) {
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

/** @param {CutoutMask} mask */
function checkMask(mask) {
  const { width, height, alpha } = mask ?? {};
  if (!(alpha instanceof Uint8Array) || !(width > 0) || alpha.length !== width * height)
    throw illegal('data', 'mask', mask, 'an object {width, height, alpha} with a byte for each pixel');
}

/**
 * @param {import('./canvas.js').Context2D} context
 * @param {CanvasImageSource} frame
 * @param {{width: number, height: number}} size
 * @param {Ground} background
 */
export function drawGround(context, frame, { width, height }, background) {
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

/**
 * Made small step by step, then large again: unlike a filter, all browsers can do it.
 * @param {import('./canvas.js').Context2D} context
 * @param {CanvasImageSource} frame
 * @param {number} width
 * @param {number} height
 */
function drawBlurred(context, frame, width, height) {
  const reduce = BLUR * Math.max(1, Math.max(width, height) / 480);
  /** @type {CanvasImageSource} */
  let picture = frame;
  for (const part of [4, 2, 1, 2]) {
    const aside = scratch(context, Math.ceil((part * width) / reduce), Math.ceil((part * height) / reduce));
    aside.context.imageSmoothingEnabled = true;
    aside.context.drawImage(picture, 0, 0, aside.canvas.width, aside.canvas.height);
    picture = aside.canvas;
  }
  context.imageSmoothingEnabled = true;
  context.drawImage(picture, 0, 0, width, height);
}

/**
 * Whether this names something that is made of the frame.
 * @param {Ground} background
 */
export function isOfFrame(background) {
  return typeof background === 'string' && OF_FRAME.includes(background);
}

/**
 * Whether this is a ground: a name, or a picture. Colours are not looked at.
 * @param {unknown} background
 * @returns {background is Ground}
 */
export function isGround(background) {
  if (typeof background === 'string') return true;
  const { width, height } = /** @type {{width?: unknown, height?: unknown}} */ (background ?? {});
  return Number(width) > 0 && Number(height) > 0;
}
