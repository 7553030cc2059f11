// Paints the frames of a video that is written: overlays, cut-out objects, masks.

import { illegal, typeTag } from '../../check/errors.js';
import { type MaskSource, labelsOf } from '../../check/masks.js';
import { GROUNDS, type Ground, boxOf, drawGround, isOfFrame } from '../../draw/cutout.js';
import { drawLabels } from '../../draw/labels.js';
import { type Drawable, type MaskAtSize, checkSize, context2d, drawable, maskAtSize } from '../edit/at-size.js';
import type { Taken } from '../edit/ahead.js';
import type { EncodeItem, Plan } from './video.js';

/**
 * How many of their surrounding pixels cut-out objects keep under a transparent mask: colours are coded for blocks of
 * pixels.
 */
const MARGIN = 4;

const BLACK = '#000000';
const WHITE = '#ffffff';

/** A frame until it is painted. */
export type Picture = ImageBitmap | VideoFrame;

/**
 * Keeps a frame, whose owner may draw the next one on the same canvas: a `VideoFrame` without copying it, and what was made
 * of the frame here as it is.
 */
async function kept({ image, close }: Drawable): Promise<Picture> {
  if (close) return image as ImageBitmap;
  return typeTag(image) === 'VideoFrame' ? (image as VideoFrame).clone() : createImageBitmap(image);
}

/** One canvas for all frames. */
export class Painter {
  canvas = new OffscreenCanvas(1, 1);
  context: OffscreenCanvasRenderingContext2D;
  aside = context2d(new OffscreenCanvas(1, 1));
  shape: OffscreenCanvasRenderingContext2D | undefined = undefined;
  size = { width: 0, height: 0 };
  /** That of the frame painted last, at the video's size. */
  mask: MaskAtSize | null = null;

  constructor(
    public masks: MaskSource,
    readonly plan: Plan,
  ) {
    this.context = context2d(this.canvas);
    // A canvas passes over what it does not know as a colour.
    if (plan.style === 'cutout' && !plan.alpha && !this.isKnown(plan.background)) {
      throw illegal('param', 'background', plan.background, GROUNDS);
    }
  }

  isKnown(background: Ground) {
    if (typeof background !== 'string' || isOfFrame(background)) return true;
    return [BLACK, WHITE].some((other) => this.fills(background, other) !== other);
  }

  /** The fill style that a colour gives over another. */
  fills(color: string, before: string) {
    this.context.fillStyle = before;
    this.context.fillStyle = color;
    return this.context.fillStyle;
  }

  /**
   * A frame that stays as it is, and its mask at the size of the frame.
   * @param t frames come in order
   */
  async take(item: EncodeItem | null, t: number): Promise<Taken<Picture | null>> {
    const frame = item === null ? null : await drawable(item, t);
    const { width, height } = frame ?? this.masks;
    const picture = frame && (await kept(frame));
    try {
      if (t === 0) this.begin(width, height);
      checkSize({ width, height }, this.size, t);
    } catch (error) {
      picture?.close();
      throw error;
    }
    return { picture, mask: this.maskOf(picture, t), close: () => picture?.close() };
  }

  async maskOf(picture: Picture | null, t: number) {
    const { masks, plan, size } = this;
    const none = new Uint8Array(0);
    // Painted as they are.
    if (plan.style === 'masks') return { ...size, labels: none, alpha: none };
    // Without a picture a mask stays as it is.
    const frame = picture ?? { ...size, data: none };
    const mask = { labels: labelsOf(masks, t), width: masks.width, height: masks.height };
    return maskAtSize(mask, frame, plan.chosen, plan.edges, plan.decoder);
  }

  paint(picture: Picture | null, mask: MaskAtSize, t: number) {
    const { context, plan } = this;
    this.mask = mask;
    context.globalCompositeOperation = 'source-over';
    if (plan.style === 'alpha') this.paintAlpha(mask);
    else if (plan.style === 'masks' || !picture) this.paintMasks(t);
    else {
      context.drawImage(picture, 0, 0);
      if (plan.style === 'overlay') this.paintOverlay(mask);
      else this.paintCutout(picture, mask);
    }
    this.pad();
  }

  begin(width: number, height: number) {
    this.size = { width, height };
    const even = this.plan.format === 'mp4' ? 2 : 1;
    Object.assign(this.canvas, { width: even * Math.ceil(width / even), height: even * Math.ceil(height / even) });
    Object.assign(this.aside.canvas, { width, height });
  }

  paintMasks(t: number) {
    this.context.fillStyle = BLACK;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.imageSmoothingEnabled = false;
    drawLabels(this.context, this.masks, t, { ...this.drawing(), opacity: 1, outline: false });
  }

  paintAlpha({ alpha, width, height }: MaskAtSize) {
    const picture = new ImageData(width, height);
    const pixels = new Uint32Array(picture.data.buffer);
    for (let p = 0; p < pixels.length; p += 1) pixels[p] = 0xff000000 + 0x10101 * Number(alpha[p]);
    this.context.putImageData(picture, 0, 0);
  }

  paintOverlay({ labels, width, height }: MaskAtSize) {
    const { outlineWidth, maskOpacity } = this.plan;
    const { context, aside } = this;
    aside.globalCompositeOperation = 'source-over';
    // Fill and outline overlap: they fade together.
    if (maskOpacity < 1) aside.clearRect(0, 0, width, height);
    drawLabels(maskOpacity < 1 ? aside : context, { width, height, numFrames: 1, labels: () => labels }, 0, {
      ...this.drawing(),
      outlineWidth,
    });
    if (maskOpacity === 1) return;
    context.globalAlpha = maskOpacity;
    context.drawImage(aside.canvas, 0, 0);
    context.globalAlpha = 1;
  }

  paintCutout(picture: Picture, mask: MaskAtSize) {
    const { aside, context, plan } = this;
    this.paintMask(mask, plan.alpha ? MARGIN : 0);
    aside.globalCompositeOperation = 'source-in';
    aside.drawImage(picture, 0, 0);
    drawGround(context, picture, this.size, plan.alpha ? BLACK : plan.background);
    context.drawImage(aside.canvas, 0, 0);
  }

  /**
   * Paints the objects white on nothing, aside.
   * @param margin how many pixels wider on all sides
   */
  paintMask({ alpha, width, height }: MaskAtSize, margin: number) {
    // One clear pixel where there is no object.
    const box = boxOf(alpha, width, height) ?? { x: 0, y: 0, width: 1, height: 1 };
    const picture = new ImageData(box.width, box.height);
    const pixels = new Uint32Array(picture.data.buffer);
    // The alpha is the last of the four bytes, on all machines that browsers run on the highest.
    // With a margin it says where colours are wanted at all: also under what is nearly clear.
    const full = margin > 0;
    for (let y = 0, p = 0; y < box.height; y += 1) {
      const row = (box.y + y) * width + box.x;
      for (let at = row; at < row + box.width; at += 1, p += 1)
        pixels[p] = 0xffffff + 0x1000000 * (full && alpha[at] ? 255 : Number(alpha[at]));
    }
    this.spread(picture, margin, box);
  }

  /**
   * Paints a picture on nothing, aside.
   * @param picture at most as large as the frame
   * @param margin how many pixels wider on all sides
   * @param place in the frame
   */
  spread(picture: ImageData, margin: number, { x, y }: { x: number; y: number }) {
    const { aside, size } = this;
    const { width, height } = picture;
    const shape = (this.shape ??= context2d(new OffscreenCanvas(size.width, size.height)));
    shape.putImageData(picture, 0, 0);
    aside.globalCompositeOperation = 'source-over';
    aside.clearRect(0, 0, size.width, size.height);
    const lay = (dx: number, dy: number) =>
      aside.drawImage(shape.canvas, 0, 0, width, height, x + dx, y + dy, width, height);
    const steps = margin > 0 ? [-margin, 0, margin] : [];
    for (const dy of steps) for (const dx of steps) lay(dx, dy);
    // Its own colours lie over those of its margin.
    lay(0, 0);
  }

  /** Returns how opaque each pixel of the frame painted last is, 0 to 255. */
  alpha(): Uint8Array<ArrayBuffer> {
    return this.mask?.alpha ?? new Uint8Array(this.size.width * this.size.height);
  }

  /** Fills the row and column beyond an odd size with copies of the last. */
  pad() {
    const { width, height } = this.size;
    const { canvas, context } = this;
    if (canvas.width > width) context.drawImage(canvas, width - 1, 0, 1, height, width, 0, 1, height);
    if (canvas.height > height) context.drawImage(canvas, 0, height - 1, canvas.width, 1, 0, height, canvas.width, 1);
  }

  drawing() {
    const { chosen, labels } = this.plan;
    return { ...labels, objects: (label: number) => chosen[label] === 1 };
  }
}
