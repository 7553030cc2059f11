// The canvas: fits the clip into its box, draws the layers over each other, finds what lies under the pointer.

import { byId, choosesMore } from './dom.js';
import { NO_ANSWERS, type Spot } from '../model/answers.js';
import { OUTLINE } from './layers/masks.js';
import { drawLayers } from './layers/layers.js';
import { adjustMask } from '../model/library.js';
import { type EdgeChoice, edgesOf } from '../model/look.js';
import { Sharp } from './sharp.js';
import { Compare, drawKept } from './panels/views.js';
import { DEFAULT_EDGES, NOWHERE, type State, type Store } from '../model/store.js';
import { Zoom } from '../model/zoom.js';
import type { Look } from '../model/export.js';
import type { Layer, View } from './layers/layer.js';

/** Device pixels per CSS pixel are not followed above this: nobody sees it, and drawing costs its square. */
const MAX_DENSITY = 2;

export class Viewer {
  canvas = byId<HTMLCanvasElement>('canvas');
  /** The element that the canvas is fitted into. */
  box = byId('pane-result');
  ctx: CanvasRenderingContext2D;
  /** Shows the frame as it came. */
  compare: Compare;
  /** Draw over the layers, in clip pixels. */
  painters: ((ctx: CanvasRenderingContext2D, view: View) => void)[] = [];
  zoom = new Zoom();
  /** CSS pixels for a pixel of the clip, when the whole of it is shown. */
  fitted = 1;
  zoomed: ((zoom: Zoom) => void)[] = [];
  queued = 0;
  /** Where the pointer is, in CSS pixels. */
  pointer: { offsetX: number; offsetY: number } | null = null;
  /** What was shown last. */
  shown: Readonly<State>;
  edged = new EdgedMask();
  sharp = new Sharp(() => this.redraw());
  view: View;

  constructor(
    readonly store: Store,
    readonly layers: Layer[],
  ) {
    this.ctx = this.canvas.getContext('2d', { willReadFrequently: false })!;
    this.compare = new Compare(store);
    this.shown = store.state;
    this.view = {
      points: null,
      image: null,
      frame: 0,
      width: 16,
      height: 9,
      unit: 1,
      visible: (object) => !store.state.hidden.has(object),
      mask: () => this.edgedMask(),
      answers: NO_ANSWERS,
      redraw: () => this.redraw(),
    };
    new ResizeObserver(() => this.fit()).observe(this.box);
    this.connectPointer();
    const watched = ['picture', 'found', 'preview', 'frame', 'hidden', 'view', 'ground'] as const;
    store.watch([...watched, 'playing', 'phase'], (state) => this.show(state));
  }

  connectPointer() {
    this.canvas.addEventListener('pointermove', ({ offsetX, offsetY }) => {
      this.pointer = { offsetX, offsetY };
      this.store.set({ spot: this.spotAt(this.pointer) });
    });
    this.canvas.addEventListener('pointerleave', () => {
      this.pointer = null;
      this.store.set({ spot: NOWHERE });
    });
  }

  /**
   * @param pick told where the picture is clicked, if more are to be chosen, and if what is there is to be taken away
   */
  onPick(pick: (spot: Spot, more: boolean, away: boolean) => void) {
    this.canvas.addEventListener('click', (event) => pick(this.spotAt(event), choosesMore(event), event.altKey));
  }

  show(state: Readonly<State>) {
    const { picture, found, frame, view } = state;
    const before = this.shown;
    this.shown = state;
    const { width, height, images } = picture;
    const isOther = picture !== before.picture || found !== before.found;
    if (isOther) for (const layer of this.layers) layer.reset?.();
    Object.assign(this.view, {
      points: found?.points ?? null,
      answers: { ...NO_ANSWERS, ...found?.answers },
      frame,
      width,
      height,
    });
    images.onReady = () => this.redraw();
    if (picture !== before.picture || view !== before.view) this.fit();
    else if (isOther) this.draw();
    else this.redraw();
  }

  /**
   * How masks look here, for a picture that looks the same.
   * @param side the picture's longer one, in pixels
   */
  maskLook(side: number): Look {
    const { opacity, fill } = this.layers.find(({ id }) => id === 'masks')!.settings;
    const { width, height } = this.view;
    // As wide as when the whole clip is shown.
    const outline = (OUTLINE * side) / (this.fitted * Math.max(width, height));
    return { opacity: opacity.value, fill: fill.value, outline };
  }

  /** The mask of the frame on screen, with its edges. */
  edgedMask() {
    const { points, frame, width, height } = this.view;
    const { edges, hidden, preview, smoothed } = this.store.state;
    const coarse = points ? null : preview?.labels(frame);
    if (coarse) return this.edged.of(coarse, { width, height }, DEFAULT_EDGES, hidden);
    const labels = smoothed?.labels(frame) ?? points?.mask(frame);
    return points && labels ? this.edged.of(labels, points.result, edges, hidden) : null;
  }

  /** Draws before the next screen refresh, once however often it is asked. */
  redraw() {
    this.queued ||= requestAnimationFrame(() => this.draw());
  }

  draw() {
    cancelAnimationFrame(this.queued);
    this.queued = 0;
    const { ctx, canvas, view } = this;
    const { picture, preview } = this.shown;
    const frame = preview?.shownAt(view.frame) ?? view.frame;
    view.image = picture.images.get(frame);
    // What is on screen stays until the frame has come.
    if (!view.image && picture.images.has(frame)) return;
    if (!preview) view.image = this.sharpImage() ?? view.image;
    ctx.resetTransform();
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    const scale = (canvas.width / view.width) * this.zoom.by;
    const [left, top] = [this.zoom.x * view.width, this.zoom.y * view.height];
    // Pixel centres lie at whole coordinates in results, at halves on a canvas.
    ctx.setTransform(scale, 0, 0, scale, scale * (0.5 - left), scale * (0.5 - top));
    if (this.shown.view === 'cutout' && view.points) drawKept(ctx, view, this.shown.ground);
    else drawLayers(ctx, this.layers, view);
    for (const paint of this.painters) paint(ctx, view);
    this.compare.draw(view.image, canvas, this.zoom);
    // What lies under a pointer that rests changes with the frame.
    if (this.pointer) this.store.set({ spot: this.spotAt(this.pointer) });
  }

  /** The frame as the source has it, where the clip rests. */
  sharpImage() {
    const { playing, job, phase } = this.store.state;
    // A run reads the file itself, and nobody reads as fast as a clip plays.
    if (phase !== 'done' || !this.shown.found?.points) return this.sharp.get(null, 0, 0);
    if (playing) return this.sharp.want(null);
    const { width, height } = this.canvas;
    return this.sharp.get(job, this.view.frame, Math.max(width, height) * this.zoom.by);
  }

  /** Sizes the canvas to the largest rectangle of the clip's shape inside the box. */
  fit() {
    const { canvas, view } = this;
    const { width, height } = this.box.getBoundingClientRect();
    const zoom = Math.min(width / view.width, height / view.height);
    // Less than a pixel, while a window changes, shows nothing.
    if (!(zoom > 0 && Math.min(width, height) >= 1)) return;
    const density = Math.min(MAX_DENSITY, devicePixelRatio || 1);
    canvas.width = Math.max(1, Math.round(view.width * zoom * density));
    canvas.height = Math.max(1, Math.round(view.height * zoom * density));
    canvas.style.width = `${canvas.width / density}px`;
    canvas.style.height = `${canvas.height / density}px`;
    this.fitted = zoom;
    view.unit = 1 / (zoom * this.zoom.by);
    this.draw();
  }

  /**
   * Shows a part of the clip enlarged.
   * @param by as against the whole
   * @param u the place that stays where it is, in parts of the canvas's width
   * @param v and height
   */
  enlarge(by: number, u: number, v: number) {
    this.zoom.to(by, u, v);
    this.showZoom();
  }

  /**
   * Moves the part that is shown.
   * @param u in parts of the canvas's width
   * @param v and height
   */
  move(u: number, v: number) {
    this.zoom.move(u, v);
    this.showZoom();
  }

  showZoom() {
    this.view.unit = 1 / (this.fitted * this.zoom.by);
    for (const tell of this.zoomed) tell(this.zoom);
    this.redraw();
  }

  /** @param tell told of what is shown, now and whenever that changes */
  onZoom(tell: (zoom: Zoom) => void) {
    this.zoomed.push(tell);
    tell(this.zoom);
  }

  /**
   * @param place in CSS pixels of the canvas
   * @returns in clip pixels
   */
  placeAt({ offsetX, offsetY }: { offsetX: number; offsetY: number }): [x: number, y: number] {
    const { unit, width, height } = this.view;
    return [this.zoom.x * width + offsetX * unit - 0.5, this.zoom.y * height + offsetY * unit - 0.5];
  }

  /** @param place in CSS pixels of the canvas */
  spotAt(place: { offsetX: number; offsetY: number }): Spot {
    const { points, frame } = this.view;
    const [x, y] = this.placeAt(place);
    if (!points) return { ...NOWHERE, x, y };
    return { x, y, object: points.objectAt(frame, x, y) };
  }
}

/** The mask on screen with its edges; made again only when something of it is another. */
class EdgedMask {
  key = '';
  from: Uint8Array | null = null;
  made: ReturnType<typeof adjustMask> | null = null;

  /** @param hidden objects that are not kept */
  of(
    labels: Uint8Array,
    { width, height }: { width: number; height: number },
    choice: EdgeChoice,
    hidden: ReadonlySet<number>,
  ) {
    const key = [choice.smallest, choice.grow, choice.feather, ...hidden].join();
    if (this.made && this.from === labels && this.key === key) return this.made;
    const objects = (label: number) => label > 0 && !hidden.has(label);
    this.made = adjustMask({ labels, width, height }, { objects, ...edgesOf(choice, { width, height }) });
    Object.assign(this, { key, from: labels });
    return this.made;
  }
}
