// The canvas: fits the clip into its box, draws the layers, and finds the object under the pointer.

import { byId, isMultiSelect } from './dom.js';
import { OUTLINE_WIDTH_PX } from './layers.js';
import { drawLayers } from './layers.js';
import { adjustMask } from '../model/library.js';
import { type EdgeSettings, maskEdges } from '../model/view-settings.js';
import { SharpFrames } from './frame-store.js';
import { Compare, drawCutoutView } from './panels/view-modes.js';
import { DEFAULT_EDGES, NOWHERE, type Spot, type State, type Store } from '../model/store.js';
import { Zoom } from '../model/zoom.js';
import type { MaskStyle } from '../model/export.js';
import type { Layer, View } from './layers.js';

/** Largest density of the canvas, in device pixels per CSS pixel; higher ones cost time and are hardly visible. */
const MAX_DENSITY = 2;

/** A position in CSS pixels of the canvas. */
export type CanvasPlace = { offsetX: number; offsetY: number };

export class Viewer {
  canvas = byId<HTMLCanvasElement>('canvas');
  box = byId('pane-result');
  ctx: CanvasRenderingContext2D;
  /** Draws the original frame. */
  compare: Compare;
  /** Functions that draw over the layers, in clip pixels. */
  painters: ((ctx: CanvasRenderingContext2D, view: View) => void)[] = [];
  zoom = new Zoom();
  /** CSS pixels per clip pixel at scale 1. */
  fitScale = 1;
  zoomListeners: ((zoom: Zoom) => void)[] = [];
  redrawRequest = 0;
  /** Position of the pointer; null outside the canvas. */
  pointer: CanvasPlace | null = null;
  lastState: Readonly<State>;
  maskCache = new EdgedMaskCache();
  sharp = new SharpFrames(() => this.redraw());
  view: View;

  constructor(
    readonly store: Store,
    readonly layers: Layer[],
  ) {
    this.ctx = this.canvas.getContext('2d', { willReadFrequently: false })!;
    this.compare = new Compare(store);
    this.lastState = store.state;
    this.view = {
      segmentation: null,
      image: null,
      frame: 0,
      width: 16,
      height: 9,
      unit: 1,
      visible: (object) => !store.state.hidden.has(object),
      mask: () => this.edgedMask(),
    };
    new ResizeObserver(() => this.fit()).observe(this.box);
    this.connectPointer();
    const keys = ['picture', 'analysis', 'preview', 'frame', 'hidden', 'view', 'backdrop'] as const;
    store.watch([...keys, 'isPlaying', 'phase'], (state) => this.show(state));
  }

  connectPointer() {
    this.canvas.addEventListener('pointermove', ({ offsetX, offsetY }) => this.movePointer({ offsetX, offsetY }));
    this.canvas.addEventListener('pointerleave', () => this.movePointer(null));
  }

  /** @param place null outside the canvas */
  movePointer(place: CanvasPlace | null) {
    this.pointer = place;
    this.store.set({ spot: place ? this.spotAt(place) : NOWHERE });
  }

  /** @param pick called with the clicked position, and flags for selecting several objects and removing */
  onPick(pick: (spot: Spot, isMulti: boolean, isRemoving: boolean) => void) {
    this.canvas.addEventListener('click', (event) => pick(this.spotAt(event), isMultiSelect(event), event.altKey));
  }

  show(state: Readonly<State>) {
    const { picture, analysis, frame, view } = state;
    const lastState = this.lastState;
    this.lastState = state;
    const { width, height, images } = picture;
    const isNewPicture = picture !== lastState.picture || analysis !== lastState.analysis;
    Object.assign(this.view, {
      segmentation: analysis?.segmentation ?? null,
      frame,
      width,
      height,
    });
    images.onReady = () => this.redraw();
    if (picture !== lastState.picture || view !== lastState.view) this.fit();
    else if (isNewPicture) this.draw();
    else this.redraw();
  }

  /**
   * Returns the drawing style of masks, scaled to another picture.
   * @param side long side of the picture, in pixels
   */
  maskStyle(side: number): MaskStyle {
    const { opacity, fill } = this.layers.find(({ id }) => id === 'masks')!.settings;
    const { width, height } = this.view;
    // Outline width at scale 1.
    const outline = (OUTLINE_WIDTH_PX * side) / (this.fitScale * Math.max(width, height));
    return { opacity: opacity.value, fill: fill.value, outline };
  }

  /** Returns the mask of the frame on screen, with adjusted edges. */
  edgedMask() {
    const { segmentation, frame, width, height } = this.view;
    const { edges, hidden, preview, smoothedMasks } = this.store.state;
    const coarse = segmentation ? null : preview?.labels(frame);
    if (coarse) return this.maskCache.adjust(coarse, { width, height }, DEFAULT_EDGES, hidden);
    const labels = smoothedMasks?.labels(frame) ?? segmentation?.mask(frame);
    return segmentation && labels ? this.maskCache.adjust(labels, segmentation.result, edges, hidden) : null;
  }

  /** Draws once before the next screen refresh; until then the canvas lacks `data-drawn`, the number of its frame. */
  redraw() {
    delete this.canvas.dataset.drawn;
    this.redrawRequest ||= requestAnimationFrame(() => this.draw());
  }

  draw() {
    cancelAnimationFrame(this.redrawRequest);
    this.redrawRequest = 0;
    const { ctx, canvas, view } = this;
    const { picture, preview } = this.lastState;
    const frame = preview?.maskedFrame(view.frame) ?? view.frame;
    view.image = picture.images.get(frame);
    // The canvas stays until the frame is loaded.
    if (!view.image && picture.images.has(frame)) return void delete canvas.dataset.drawn;
    if (!preview) view.image = this.sharpImage() ?? view.image;
    ctx.resetTransform();
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    const scale = (canvas.width / view.width) * this.zoom.scale;
    const [left, top] = [this.zoom.x * view.width, this.zoom.y * view.height];
    // Pixel centres lie at whole coordinates in results, at halves on a canvas.
    ctx.setTransform(scale, 0, 0, scale, scale * (0.5 - left), scale * (0.5 - top));
    if (this.lastState.view === 'cutout' && view.segmentation) drawCutoutView(ctx, view, this.lastState.backdrop);
    else drawLayers(ctx, this.layers, view);
    for (const paint of this.painters) paint(ctx, view);
    this.compare.draw(view.image, canvas, this.zoom);
    canvas.dataset.drawn = String(view.frame);
    // The object under a resting pointer changes with the frame.
    if (this.pointer) this.store.set({ spot: this.spotAt(this.pointer) });
  }

  /** Returns the full-resolution frame while the clip is paused. */
  sharpImage() {
    const { isPlaying, job, phase } = this.store.state;
    // Not during a run, which reads the file itself, nor during playback.
    if (phase !== 'done' || !this.lastState.analysis) return this.sharp.get(null, 0, 0);
    if (isPlaying) return this.sharp.schedule(null);
    const { width, height } = this.canvas;
    return this.sharp.get(job, this.view.frame, Math.max(width, height) * this.zoom.scale);
  }

  /** Sizes the canvas to the largest rectangle of the clip's shape inside the box. */
  fit() {
    const { canvas, view } = this;
    const { width, height } = this.box.getBoundingClientRect();
    const zoom = Math.min(width / view.width, height / view.height);
    // The box may be empty while the window changes.
    if (!(zoom > 0 && Math.min(width, height) >= 1)) return;
    const density = Math.min(MAX_DENSITY, devicePixelRatio || 1);
    canvas.width = Math.max(1, Math.round(view.width * zoom * density));
    canvas.height = Math.max(1, Math.round(view.height * zoom * density));
    canvas.style.width = `${canvas.width / density}px`;
    canvas.style.height = `${canvas.height / density}px`;
    this.fitScale = zoom;
    view.unit = 1 / (zoom * this.zoom.scale);
    this.draw();
  }

  /**
   * Zooms about a fixed point of the canvas.
   * @param scale relative to the whole clip
   * @param u as a share of the canvas's width
   * @param v as a share of its height
   */
  zoomTo(scale: number, u: number, v: number) {
    this.zoom.zoomTo(scale, u, v);
    this.showZoom();
  }

  /**
   * Pans the visible part.
   * @param u as a share of the canvas's width
   * @param v as a share of its height
   */
  pan(u: number, v: number) {
    this.zoom.pan(u, v);
    this.showZoom();
  }

  showZoom() {
    this.view.unit = 1 / (this.fitScale * this.zoom.scale);
    for (const listener of this.zoomListeners) listener(this.zoom);
    this.redraw();
  }

  /** @param tell called with the zoom, now and whenever it changes */
  onZoom(tell: (zoom: Zoom) => void) {
    this.zoomListeners.push(tell);
    tell(this.zoom);
  }

  /** Returns the position in clip pixels. */
  placeAt({ offsetX, offsetY }: CanvasPlace): [x: number, y: number] {
    const { unit, width, height } = this.view;
    return [this.zoom.x * width + offsetX * unit - 0.5, this.zoom.y * height + offsetY * unit - 0.5];
  }

  spotAt(place: CanvasPlace): Spot {
    const { segmentation, frame } = this.view;
    const [x, y] = this.placeAt(place);
    if (!segmentation) return { ...NOWHERE, x, y };
    return { x, y, object: segmentation.objectAt(frame, x, y) };
  }
}

/** Caches the mask on screen with adjusted edges. */
class EdgedMaskCache {
  key = '';
  from: Uint8Array | null = null;
  made: ReturnType<typeof adjustMask> | null = null;

  /** @param hidden objects to leave out */
  adjust(
    labels: Uint8Array,
    { width, height }: { width: number; height: number },
    choice: EdgeSettings,
    hidden: ReadonlySet<number>,
  ) {
    const key = [choice.smallest, choice.grow, choice.feather, ...hidden].join();
    if (this.made && this.from === labels && this.key === key) return this.made;
    const objects = (label: number) => label > 0 && !hidden.has(label);
    this.made = adjustMask({ labels, width, height }, { objects, ...maskEdges(choice, { width, height }) });
    Object.assign(this, { key, from: labels });
    return this.made;
  }
}
