// Paints the frames of a video: overlays, cut-out objects, masks.

import { illegal, typeTag } from '../../check/errors.js';
import { type MaskSource, readLabels } from '../../check/masks.js';
import { type Backdrop, LEGAL_BACKDROPS, drawBackdrop, findBox, isFrameBackdrop } from '../../draw/cutout.js';
import { drawLabels } from '../../draw/labels.js';
import {
  type Drawable,
  type MaskAtSize,
  type PendingFrame,
  checkSize,
  getContext2d,
  scaleMask,
  toDrawable,
} from '../edit/at-size.js';
import type { EncodeItem, VideoPlan } from './video.js';

/**
 * Pixels around cut-out objects that keep their colours under a transparent mask, as codecs compress blocks of pixels;
 * chosen by eye.
 */
const MARGIN_PX = 4;

const BLACK = '#000000';
const WHITE = '#ffffff';

/** A frame that waits to be painted. */
export type Picture = ImageBitmap | VideoFrame;

/**
 * Keeps a frame, as its owner may draw the next one on the same canvas: a `VideoFrame` without copying it, and an image
 * made from the frame as it is.
 */
async function keepFrame({ image, close }: Drawable): Promise<Picture> {
  if (close) return image as ImageBitmap;
  return typeTag(image) === 'VideoFrame' ? (image as VideoFrame).clone() : createImageBitmap(image);
}

/** Paints all frames on one canvas. */
export class Painter {
  canvas = new OffscreenCanvas(1, 1);
  context: OffscreenCanvasRenderingContext2D;
  layer = getContext2d(new OffscreenCanvas(1, 1));
  size = { width: 0, height: 0 };
  /** The frame painted last, and its mask at the video's size. */
  picture: Picture | null = null;
  mask: MaskAtSize | null = null;

  constructor(
    public masks: MaskSource,
    readonly plan: VideoPlan,
  ) {
    this.context = getContext2d(this.canvas);
    // A canvas ignores a string that it does not know as a colour.
    if (plan.style === 'cutout' && !plan.alpha && !this.#isValidBackdrop(plan.background)) {
      throw illegal('param', 'background', plan.background, LEGAL_BACKDROPS);
    }
  }

  #isValidBackdrop(background: Backdrop) {
    if (typeof background !== 'string' || isFrameBackdrop(background)) return true;
    return [BLACK, WHITE].some((color) => this.#setFillStyle(background, color) !== color);
  }

  /** Returns the fill style after setting a colour over another one. */
  #setFillStyle(color: string, before: string) {
    this.context.fillStyle = before;
    this.context.fillStyle = color;
    return this.context.fillStyle;
  }

  /**
   * Keeps a frame and starts enlarging its mask.
   * @param t frames come in order
   */
  async take(item: EncodeItem | null, t: number): Promise<PendingFrame<Picture | null>> {
    const frame = item === null ? null : await toDrawable(item, t);
    const { width, height } = frame ?? this.masks;
    const picture = frame && (await keepFrame(frame));
    try {
      if (t === 0) this.#begin(width, height);
      checkSize({ width, height }, this.size, t);
    } catch (error) {
      picture?.close();
      throw error;
    }
    return { picture, mask: this.#computeMask(picture, t), close: () => picture?.close() };
  }

  async #computeMask(picture: Picture | null, t: number) {
    const { masks, plan, size } = this;
    const empty = new Uint8Array(0);
    // Masks are painted as they are.
    if (plan.style === 'masks') return { ...size, labels: empty, alpha: empty };
    // Without a picture a mask is only scaled.
    const frame = picture ?? { ...size, data: empty };
    const mask = { labels: readLabels(masks, t), width: masks.width, height: masks.height };
    return scaleMask(mask, frame, plan.selected, plan.edges, plan.decoder, plan.alpha);
  }

  paint(picture: Picture | null, mask: MaskAtSize, t: number) {
    const { context, plan } = this;
    Object.assign(this, { picture, mask });
    // Encoded as they are.
    if (plan.alpha || plan.style === 'alpha') return;
    context.globalCompositeOperation = 'source-over';
    if (plan.style === 'masks' || !picture) this.#paintMasks(t);
    else {
      context.drawImage(picture, 0, 0);
      if (plan.style === 'overlay') this.#paintOverlay(mask);
      else this.#paintCutout(picture, mask);
    }
    this.#pad();
  }

  #begin(width: number, height: number) {
    this.size = { width, height };
    const even = this.plan.format === 'mp4' ? 2 : 1;
    Object.assign(this.canvas, { width: even * Math.ceil(width / even), height: even * Math.ceil(height / even) });
    Object.assign(this.layer.canvas, { width, height });
  }

  #paintMasks(t: number) {
    this.context.fillStyle = BLACK;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.imageSmoothingEnabled = false;
    drawLabels(this.context, this.masks, t, { ...this.#getDrawOptions(), opacity: 1, outline: false });
  }

  #paintOverlay({ labels, width, height }: MaskAtSize) {
    const { outlineWidth, maskOpacity } = this.plan;
    const { context, layer } = this;
    layer.globalCompositeOperation = 'source-over';
    // Fill and outline overlap: they fade together.
    if (maskOpacity < 1) layer.clearRect(0, 0, width, height);
    drawLabels(maskOpacity < 1 ? layer : context, { width, height, numFrames: 1, labels: () => labels }, 0, {
      ...this.#getDrawOptions(),
      outlineWidth,
    });
    if (maskOpacity === 1) return;
    context.globalAlpha = maskOpacity;
    context.drawImage(layer.canvas, 0, 0);
    context.globalAlpha = 1;
  }

  #paintCutout(picture: Picture, mask: MaskAtSize) {
    const { layer, context, plan } = this;
    this.#paintMask(mask);
    layer.globalCompositeOperation = 'source-in';
    layer.drawImage(picture, 0, 0);
    drawBackdrop(context, picture, this.size, plan.background);
    context.drawImage(layer.canvas, 0, 0);
  }

  /** Paints the objects white on a clear layer. */
  #paintMask({ alpha, width, height }: MaskAtSize) {
    // One clear pixel where there is no object.
    const box = findBox(alpha, width, height) ?? { x: 0, y: 0, width: 1, height: 1 };
    const picture = new ImageData(box.width, box.height);
    const pixels = new Uint32Array(picture.data.buffer);
    for (let y = 0, p = 0; y < box.height; y += 1) {
      const row = (box.y + y) * width + box.x;
      for (let index = row; index < row + box.width; index += 1, p += 1)
        pixels[p] = 0xffffff + 0x1000000 * Number(alpha[index]);
    }
    const { layer } = this;
    layer.globalCompositeOperation = 'source-over';
    layer.clearRect(0, 0, width, height);
    layer.putImageData(picture, box.x, box.y);
  }

  /** Returns the pixels of the frame painted last; those of a transparent video are black unless an object is near. */
  pixels(): PaintedPixels {
    const { width, height } = this.canvas;
    const { mask, plan, context, picture } = this;
    const read = () => context.getImageData(0, 0, width, height).data;
    if (!plan.alpha || !mask || !picture) return { data: read(), width, height, box: { x: 0, y: 0, width, height } };
    const box = findBox(mask.alpha, width, height);
    if (!box) return { data: new Uint8ClampedArray(0), width, height, box: { x: 0, y: 0, width: 0, height: 0 } };
    if (!mask.picture) context.drawImage(picture, 0, 0);
    const data = mask.picture ? new Uint8ClampedArray(mask.picture.buffer) : read();
    blackenAround({ data, width, height }, box, mask.alpha);
    return { data, width, height, box: widenBox(box, this.canvas) };
  }

  /** Returns the opacity of each pixel of the frame painted last, 0 to 255. */
  alpha(): Uint8Array<ArrayBuffer> {
    return this.mask?.alpha ?? new Uint8Array(this.size.width * this.size.height);
  }

  /** Extends an odd size by a row or column, a copy of the last. */
  #pad() {
    const { width, height } = this.size;
    const { canvas, context } = this;
    if (canvas.width > width) context.drawImage(canvas, width - 1, 0, 1, height, width, 0, 1, height);
    if (canvas.height > height) context.drawImage(canvas, 0, height - 1, canvas.width, 1, 0, height, canvas.width, 1);
  }

  #getDrawOptions() {
    const { selected, labels } = this.plan;
    return { ...labels, objects: (label: number) => selected[label] === 1 };
  }
}

/** Alpha is the last of the four bytes: the highest one on the little-endian machines that browsers run on. */
const OPAQUE_BLACK = 0xff000000;

type ObjectBox = NonNullable<ReturnType<typeof findBox>>;

/** RGBA pixels, which are black outside of `box`; the box begins at even columns and rows. */
export type PaintedPixels = { data: Uint8ClampedArray; width: number; height: number; box: ObjectBox };

/** Adds the margin of colours to a box, and up to a row and a column. */
function widenBox(box: ObjectBox, { width, height }: { width: number; height: number }): ObjectBox {
  const [x, y] = [box.x - MARGIN_PX, box.y - MARGIN_PX].map((side) => Math.max(0, side - (side & 1))) as [
    number,
    number,
  ];
  const [right, bottom] = [box.x + box.width + MARGIN_PX, box.y + box.height + MARGIN_PX];
  return { x, y, width: Math.min(width, right) - x, height: Math.min(height, bottom) - y };
}

/**
 * Makes all pixels black that are farther than `MARGIN_PX` from objects, across or down.
 * @param box around the objects
 * @param alpha opacity of the objects
 */
export function blackenAround(
  { data, width, height }: { data: Uint8ClampedArray; width: number; height: number },
  box: ObjectBox,
  alpha: Uint8Array,
) {
  const pixels = new Uint32Array(data.buffer);
  const [left, right] = [Math.max(0, box.x - MARGIN_PX), Math.min(width, box.x + box.width + MARGIN_PX)];
  const [top, bottom] = [Math.max(0, box.y - MARGIN_PX), Math.min(height, box.y + box.height + MARGIN_PX)];
  /** Number of pixels of objects in each column, within the margin of the row. */
  const counts = new Uint8Array(width + MARGIN_PX);
  const addRow = (y: number, change: number) => {
    if (y < top || y >= bottom) return;
    for (let x = left, p = y * width + left; x < right; x += 1, p += 1) if (alpha[p]) counts[x]! += change;
  };
  for (let y = top; y < top + MARGIN_PX; y += 1) addRow(y, 1);
  pixels.fill(OPAQUE_BLACK, 0, top * width);
  for (let y = top; y < bottom; y += 1) {
    addRow(y + MARGIN_PX, 1);
    addRow(y - MARGIN_PX - 1, -1);
    const row = y * width;
    pixels.fill(OPAQUE_BLACK, row, row + left);
    /** Column of the last object: the margin before the first counts too. */
    let last = -Infinity;
    for (let x = left; x < left + MARGIN_PX; x += 1) if (counts[x]) last = x;
    for (let x = left; x < right; x += 1) {
      if (counts[x + MARGIN_PX]) last = x + MARGIN_PX;
      if (x - last > MARGIN_PX) pixels[row + x] = OPAQUE_BLACK;
    }
    pixels.fill(OPAQUE_BLACK, row + right, row + width);
  }
  pixels.fill(OPAQUE_BLACK, bottom * width);
}
