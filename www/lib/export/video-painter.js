// Paints the frames of a video that is written: overlays, cut-out objects, masks.

import { drawLabels, labelPicture } from '../draw/labels.js';
import { TraceCutError, illegal, typeTag } from '../errors.js';
import { labelsOf } from './mask-source.js';

/** @typedef {import('./video.js').EncodeFrame} EncodeFrame */
/**
 * What a canvas can draw; `close` where it was made of a frame and is to be let go. @typedef {{image:
 * CanvasImageSource, width: number, height: number, close?: () => void}} Drawable
 */

/**
 * Cut-out objects keep so many of their surrounding pixels under a transparent mask: colours are coded for blocks of
 * pixels.
 */
const MARGIN = 4;

const BLACK = '#000000';
const WHITE = '#ffffff';

/** One canvas for all frames. */
export class Painter {
  /**
   * @param {import('./mask-source.js').MaskSource} masks
   * @param {import('./video.js').Plan} plan
   */
  constructor(masks, plan) {
    this.masks = masks;
    this.plan = plan;
    this.canvas = new OffscreenCanvas(1, 1);
    this.context = context2d(this.canvas);
    this.aside = context2d(new OffscreenCanvas(1, 1));
    this.size = { width: 0, height: 0 };
    this.t = 0;
    // A canvas passes over what it does not know as a colour.
    if (
      plan.style === 'cutout' &&
      !plan.alpha &&
      [BLACK, WHITE].every((other) => this.fills(plan.background, other) === other)
    ) {
      throw illegal('param', 'background', plan.background, "'transparent' or a CSS colour");
    }
  }

  /**
   * The fill style that a colour gives over another.
   * @param {string} color
   * @param {string} before
   */
  fills(color, before) {
    this.context.fillStyle = before;
    this.context.fillStyle = color;
    return this.context.fillStyle;
  }

  /**
   * @param {EncodeFrame | {frame: EncodeFrame} | null} item
   * @param {number} t
   */
  async paint(item, t) {
    const frame = item === null ? null : await drawable(item, t);
    try {
      this.paintStyle(frame, t);
    } finally {
      frame?.close?.();
    }
    this.pad();
  }

  /**
   * @param {Drawable | null} frame
   * @param {number} t
   */
  paintStyle(frame, t) {
    const { width, height } = frame ?? this.masks;
    if (t === 0) this.begin(width, height);
    if (width !== this.size.width || height !== this.size.height) {
      throw new TraceCutError(
        'frame-size-changed',
        `frame ${t} is ${width} × ${height} pixels (expected ${this.size.width} × ${this.size.height}, as the first)`,
      );
    }
    this.t = t;
    this.context.globalCompositeOperation = 'source-over';
    if (this.plan.style === 'masks' || !frame) this.paintMasks(t);
    else if (this.plan.style === 'overlay') this.paintOverlay(frame, t);
    else this.paintCutout(frame, t);
  }

  /**
   * @param {number} width
   * @param {number} height
   */
  begin(width, height) {
    this.size = { width, height };
    const even = this.plan.format === 'mp4' ? 2 : 1;
    Object.assign(this.canvas, { width: even * Math.ceil(width / even), height: even * Math.ceil(height / even) });
    Object.assign(this.aside.canvas, { width, height });
  }

  /** @param {number} t */
  paintMasks(t) {
    this.context.fillStyle = BLACK;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.imageSmoothingEnabled = false;
    drawLabels(this.context, this.masks, t, { ...this.drawing(), opacity: 1, outline: false });
  }

  /**
   * @param {Drawable} frame
   * @param {number} t
   */
  paintOverlay({ image }, t) {
    const { width, height } = this.size;
    this.context.drawImage(image, 0, 0, width, height);
    this.context.save();
    this.context.scale(width / this.masks.width, height / this.masks.height);
    drawLabels(this.context, this.masks, t, {
      ...this.drawing(),
      outlineWidth: (this.plan.outlineWidth * this.masks.width) / width,
    });
    this.context.restore();
  }

  /**
   * @param {Drawable} frame
   * @param {number} t
   */
  paintCutout({ image }, t) {
    const { width, height } = this.size;
    const { aside, context, plan } = this;
    this.paintMask(t, plan.alpha ? MARGIN : 0);
    aside.globalCompositeOperation = 'source-in';
    aside.drawImage(image, 0, 0, width, height);
    context.fillStyle = plan.alpha ? BLACK : plan.background;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    context.drawImage(aside.canvas, 0, 0);
  }

  /**
   * Paints the objects white on nothing, aside.
   * @param {number} t
   * @param {number} margin so many pixels wider on all sides
   */
  paintMask(t, margin) {
    const { aside, masks, size } = this;
    aside.globalCompositeOperation = 'source-over';
    aside.clearRect(0, 0, size.width, size.height);
    const mask = { labels: labelsOf(masks, t), width: masks.width, height: masks.height };
    const picture = labelPicture(aside, mask, this.plan.chosen, () => WHITE);
    const steps = margin > 0 ? [-margin, 0, margin] : [0];
    for (const dy of steps) for (const dx of steps) aside.drawImage(picture, dx, dy, size.width, size.height);
  }

  /** @returns {Uint8Array<ArrayBuffer>} how opaque each pixel of the frame painted last is, 0 to 255 */
  alpha() {
    const { width, height } = this.size;
    this.paintMask(this.t, 0);
    const { data } = this.aside.getImageData(0, 0, width, height);
    const values = new Uint8Array(width * height);
    for (let p = 0; p < values.length; p += 1) values[p] = Number(data[4 * p + 3]);
    return values;
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
    return { ...labels, objects: (/** @type {number} */ label) => chosen[label] === 1 };
  }
}

/** @param {OffscreenCanvas} canvas */
function context2d(canvas) {
  const context = canvas.getContext('2d', { willReadFrequently: true });
  if (!context) throw new TraceCutError('unsupported', 'the browser gave no 2d canvas to paint the video on');
  return context;
}

/**
 * @param {EncodeFrame | {frame: EncodeFrame}} item
 * @param {number} t
 * @returns {Promise<Drawable>}
 */
async function drawable(item, t) {
  const frame = /** @type {unknown} */ (typeTag(item) === 'Object' && 'frame' in item ? item.frame : item);
  switch (typeTag(frame)) {
    case 'VideoFrame': {
      const image = /** @type {VideoFrame} */ (frame);
      return { image, width: image.displayWidth, height: image.displayHeight };
    }
    case 'HTMLVideoElement': {
      const image = /** @type {HTMLVideoElement} */ (frame);
      return { image, width: image.videoWidth, height: image.videoHeight };
    }
    case 'HTMLImageElement': {
      const image = /** @type {HTMLImageElement} */ (frame);
      return { image, width: image.naturalWidth, height: image.naturalHeight };
    }
    case 'ImageBitmap':
    case 'HTMLCanvasElement':
    case 'OffscreenCanvas': {
      const image = /** @type {ImageBitmap} */ (frame);
      return { image, width: image.width, height: image.height };
    }
    case 'Blob':
    case 'File': {
      const image = await createImageBitmap(/** @type {Blob} */ (frame));
      return { image, width: image.width, height: image.height, close: () => image.close() };
    }
    default:
      return fromPixels(frame, t);
  }
}

/**
 * @param {unknown} frame
 * @param {number} t
 * @returns {Drawable}
 */
function fromPixels(frame, t) {
  const { data, width, height } = /** @type {Partial<import('../frames.js').PixelFrame>} */ (frame ?? {});
  if (!ArrayBuffer.isView(data) || !(Number(width) > 0) || data.length !== 4 * Number(width) * Number(height)) {
    throw illegal(
      'data',
      `frame ${t}`,
      frame,
      'something a canvas can draw, ImageData, {data, width, height} in RGBA, or a Blob of an image',
    );
  }
  const canvas = new OffscreenCanvas(Number(width), Number(height));
  context2d(canvas).putImageData(new ImageData(new Uint8ClampedArray(data), Number(width), Number(height)), 0, 0);
  return { image: canvas, width: canvas.width, height: canvas.height };
}
