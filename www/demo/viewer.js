/** The canvas: fits the clip into its box, draws the layers over each other, finds what lies under the pointer. @module */

import { NO_ANSWERS } from './layer.js';
import { drawLayers } from './layers.js';

/** @typedef {import('./layer.js').View} View */

/** Device pixels per CSS pixel are not followed above this: nobody sees it, and drawing costs its square. */
const MAX_DENSITY = 2;

/** How near the pointer must be to a point, in CSS pixels. */
const REACH_PX = 14;

/** @typedef {import('./layer.js').Spot} Spot */

/**
 * Frames to show: `get` gives null for one that is still on its way; then `onReady` is called.
 *
 * @typedef {{get: (frame: number) => CanvasImageSource | null, has: (frame: number) => boolean, onReady: () => void}} Frames
 */

/** @type {Frames} */
const NO_FRAMES = { get: () => null, has: () => false, onReady() {} };

/**
 * @param {CanvasImageSource} image
 * @returns {Frames} it alone
 */
export function oneFrame(image) {
  return { get: (frame) => (frame === 0 ? image : null), has: (frame) => frame === 0, onReady() {} };
}

/** @type {Spot} */
export const NOWHERE = { x: -1, y: -1, object: -1, trajectory: -1 };

export class Viewer {
  /**
   * @param {object} parts
   * @param {HTMLCanvasElement} parts.canvas
   * @param {HTMLElement} parts.box the element that the canvas is fitted into
   * @param {import('./layer.js').Layer[]} parts.layers
   * @param {import('./compare.js').Compare} parts.compare shows the frame as it came
   * @param {(object: number) => boolean} parts.visible
   * @param {(ctx: CanvasRenderingContext2D, view: View) => void} parts.onDraw draws over the layers
   * @param {(spot: Spot) => void} parts.onHover
   * @param {(spot: Spot) => void} parts.onPick
   */
  constructor({ canvas, box, layers, compare, visible, onDraw, onHover, onPick }) {
    this.canvas = canvas;
    this.box = box;
    this.layers = layers;
    this.compare = compare;
    this.onDraw = onDraw;
    this.onHover = onHover;
    this.onPick = onPick;
    this.ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d', { willReadFrequently: false }));
    /** @type {Frames} */
    this.images = NO_FRAMES;
    this.queued = 0;
    /** @type {{offsetX: number, offsetY: number} | null} Where the pointer is, in CSS pixels. */
    this.pointer = null;
    /** @type {View} */
    this.view = {
      points: null,
      windows: false,
      image: null,
      frame: 0,
      width: 16,
      height: 9,
      unit: 1,
      visible,
      answers: NO_ANSWERS,
      redraw: () => this.redraw(),
    };
    new ResizeObserver(() => this.fit()).observe(box);
    canvas.addEventListener('pointermove', ({ offsetX, offsetY }) => {
      this.pointer = { offsetX, offsetY };
      this.onHover(this.spotAt(this.pointer));
    });
    canvas.addEventListener('pointerleave', () => {
      this.pointer = null;
      this.onHover(NOWHERE);
    });
    canvas.addEventListener('click', (event) => this.onPick(this.spotAt(event)));
  }

  /**
   * Starts a new clip; the result of the last one is forgotten.
   *
   * @param {number} width in pixels
   * @param {number} height
   * @param {Frames} [images] the frames, which may still be arriving
   */
  setClip(width, height, images = NO_FRAMES) {
    this.images = images;
    images.onReady = () => this.redraw();
    Object.assign(this.view, { points: null, windows: false, answers: NO_ANSWERS, frame: 0, width, height });
    this.compare.setAspect(width / height);
    for (const layer of this.layers) layer.reset?.();
    this.fit();
  }

  /**
   * @param {import('./points.js').Points | null} points null for a still image
   * @param {Partial<import('./layer.js').Answers>} answers
   * @param {boolean} [windows] whether the clip was taken window by window
   */
  setResult(points, answers, windows = false) {
    Object.assign(this.view, { points, windows, answers: { ...NO_ANSWERS, ...answers } });
    for (const layer of this.layers) layer.reset?.();
    this.redraw();
  }

  /** @param {number} frame */
  show(frame) {
    this.view.frame = frame;
    this.redraw();
  }

  /** Draws before the next screen refresh, once however often it is asked. */
  redraw() {
    this.queued ||= requestAnimationFrame(() => this.draw());
  }

  /** Draws now. */
  draw() {
    cancelAnimationFrame(this.queued);
    this.queued = 0;
    const { ctx, canvas, view } = this;
    view.image = this.images.get(view.frame);
    // What is on screen stays until the frame has come.
    if (!view.image && this.images.has(view.frame)) return;
    ctx.resetTransform();
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    const scale = canvas.width / view.width;
    // Pixel centres lie at whole coordinates in results, at halves on a canvas.
    ctx.setTransform(scale, 0, 0, scale, scale / 2, scale / 2);
    drawLayers(ctx, this.layers, view);
    this.onDraw(ctx, view);
    this.compare.draw(view.image, canvas);
    // What lies under a pointer that rests changes with the frame.
    if (this.pointer) this.onHover(this.spotAt(this.pointer));
  }

  /** Sizes the canvas to the largest rectangle of the clip's shape inside the box. */
  fit() {
    const { canvas, view } = this;
    const { clientWidth, clientHeight } = this.box;
    const zoom = Math.min(clientWidth / view.width, clientHeight / view.height);
    if (!(zoom > 0)) return;
    const density = Math.min(MAX_DENSITY, devicePixelRatio || 1);
    canvas.width = Math.max(1, Math.round(view.width * zoom * density));
    canvas.height = Math.max(1, Math.round(view.height * zoom * density));
    canvas.style.width = `${canvas.width / density}px`;
    canvas.style.height = `${canvas.height / density}px`;
    view.unit = 1 / zoom;
    this.draw();
  }

  /**
   * @param {{offsetX: number, offsetY: number}} place in CSS pixels of the canvas
   * @returns {Spot} what is there
   */
  spotAt({ offsetX, offsetY }) {
    const { points, frame, unit, visible } = this.view;
    const x = offsetX * unit - 0.5;
    const y = offsetY * unit - 0.5;
    if (!points) return { ...NOWHERE, x, y };
    const trajectory = points.nearest(frame, x, y, REACH_PX * unit, visible);
    const object = points.objectAt(frame, x, y);
    // Without masks the nearest point tells.
    return { x, y, trajectory, object: object < 0 && trajectory >= 0 ? points.object[trajectory] : object };
  }
}
