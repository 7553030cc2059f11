/**
 * Painting on the canvas: strokes, a brush and an eraser for the object that is chosen, and things that were missed, which
 * grow from a click. What is done in one frame is carried to the others, as far as the picture agrees.
 * @module
 */

import { TOUCH, byId } from '../dom.js';
import { plural } from '../words.js';

/** @typedef {import('../run/corrections.js').Corrections} Corrections */
/** @typedef {import('../run/job.js').Painted} Painted */
/** @typedef {'paint' | 'erase' | 'add'} BrushTool */

/** The object that is begun by painting. */
export const NEW_OBJECT = -1;

export const BRUSH_HELP = {
  paint: 'Paint what belongs to the object.',
  erase: 'Wipe away what does not belong to the object.',
  add: TOUCH
    ? 'Tap a thing that was missed; a tap beside it adds to it.'
    : 'Click a thing that was missed; a click beside it adds to it, with Alt it takes away.',
};

/**
 * @param {string} tool
 * @returns {tool is BrushTool}
 */
export function isBrush(tool) {
  return tool in BRUSH_HELP;
}

/**
 * Regions that a click may mean, the smallest first, which of them is in force, in frame t, and how: `count` steps of
 * correction are done with it.
 *
 * @typedef {{regions: import('../library.js').Region[], at: number, t: number, painted:
 *   Pick<import('../run/job.js').ToPaint, 'label' | 'over'>, count?: number}} Offer
 */

/**
 * What a brush needs of the panel that it is in.
 *
 * @typedef {object} Host
 * @property {import('../store.js').Store} store
 * @property {() => Corrections | null} corrector
 * @property {() => number} object the one that is meant
 * @property {(object: number) => void} choose
 * @property {(frames: number[] | null) => void} show
 * @property {(text: string, wrong?: boolean) => void} tell
 */

export class Brush {
  /** @param {Host} host */
  constructor(host) {
    this.host = host;
    /** @type {Promise<unknown>} One edit after the other. */
    this.working = Promise.resolve();
    /** @type {AbortController | null} Of what is being carried. */
    this.carrying = null;
    /** @type {Offer | null} The sizes that the thing added last may have. */
    this.offer = null;
    this.size = /** @type {HTMLInputElement} */ (byId('brush-size'));
    this.others = /** @type {HTMLInputElement} */ (byId('brush-carry'));
    byId('brush-stop').addEventListener('click', () => this.stop());
    byId('add-smaller').addEventListener('click', () => this.resize(-1));
    byId('add-larger').addEventListener('click', () => this.resize(1));
  }

  /** Half the width of the brush, in CSS pixels. */
  get radius() {
    return this.size.valueAsNumber / 2;
  }

  /** The button keeps its place. @param {boolean} there */
  offerStop(there) {
    /** @type {HTMLButtonElement} */ (byId('brush-stop')).disabled = !there;
  }

  /** Ends carrying; what was reached stays. */
  stop() {
    this.carrying?.abort();
  }

  /** Resolves when nothing is under way any more. */
  async settled() {
    this.stop();
    await this.working;
  }

  /**
   * A stroke that was painted or wiped.
   *
   * @param {Stroke} stroke in clip pixels
   * @param {BrushTool} tool
   */
  stroke(stroke, tool) {
    const object = this.host.object();
    if (tool === 'erase') this.edit({ label: 0, stroke, ...(object > 0 ? { over: [object] } : {}) });
    else this.edit({ label: object, stroke });
  }

  /**
   * A click on what was missed: the region that grows from there becomes an object, or goes to the one that is clicked or
   * was added last.
   *
   * @param {{x: number, y: number}} place in clip pixels
   * @param {number} clicked the object there
   * @param {boolean} away whether it is taken away
   */
  async add(place, clicked, away) {
    const { host } = this;
    const { frame, visit } = host.store.state;
    this.take(null);
    // From the background nothing is taken away.
    if (away && clicked <= 0) return;
    try {
      const grown = await host.corrector()?.grown(frame, place);
      if (!grown || visit !== host.store.state.visit) return;
      const { regions, likeliest } = grown;
      const meant = Math.max(0, clicked) || host.object();
      /** @type {Pick<import('../run/job.js').ToPaint, 'label' | 'over'>} */
      const painted = away ? { label: 0, over: [clicked] } : { label: meant > 0 ? meant : NEW_OBJECT, over: [0] };
      this.offer = { regions, at: likeliest, t: frame, painted };
      this.paintOffer();
    } catch (error) {
      if (visit === host.store.state.visit) this.refuse(error);
    }
  }

  /**
   * The thing that was added last becomes smaller or larger.
   *
   * @param {-1 | 1} by
   */
  async resize(by) {
    const { host, offer } = this;
    const corrector = host.corrector();
    if (!offer || !corrector || !offer.regions[offer.at + by]) return;
    this.take(null);
    await this.settled();
    // Something else was done since.
    if (corrector.count() !== offer.count) return;
    host.show(await corrector.undo());
    this.offer = { ...offer, at: offer.at + by };
    this.paintOffer();
  }

  paintOffer() {
    const { offer } = this;
    if (!offer) return;
    const { regions, at, t, painted } = offer;
    this.edit({ ...painted, t, region: regions[at] });
  }

  /** @param {Offer | null} offer */
  take(offer) {
    this.offer = offer;
    const { regions = [], at = 0 } = offer ?? {};
    /** @type {HTMLButtonElement} */ (byId('add-smaller')).disabled = !regions[at - 1];
    /** @type {HTMLButtonElement} */ (byId('add-larger')).disabled = !regions[at + 1];
  }

  /** @param {import('../run/job.js').ToPaint} painted with `NEW_OBJECT` for a label that nothing has */
  edit(painted) {
    this.working = this.working.then(() => this.work(painted)).catch(() => {});
  }

  /** @param {unknown} error */
  refuse(error) {
    this.host.tell(`That is not possible here: ${error instanceof Error ? error.message : error}.`, true);
  }

  /** @param {import('../run/job.js').ToPaint} painted */
  async work(painted) {
    const { host } = this;
    const corrector = host.corrector();
    if (!corrector) return;
    const { visit } = host.store.state;
    const same = () => visit === host.store.state.visit;
    try {
      const label = painted.label === NEW_OBJECT ? corrector.newLabel() : painted.label;
      const edit = await corrector.paint({ ...painted, label });
      if (!same()) return;
      const { offer } = this;
      const offered = offer?.regions.some((region) => region === painted.region) ? offer : null;
      // Of another size it has the same label.
      this.take(offered && { ...offered, painted: { label, over: painted.over }, count: corrector.count() });
      host.show(edit.frames);
      if (label > 0) host.choose(label);
      if (this.others.checked) await this.carry(corrector, edit, same);
      else host.tell(`In frame ${edit.frames[0] + 1}.`);
    } catch (error) {
      if (same()) this.refuse(error);
    }
  }

  /**
   * @param {Corrections} corrector
   * @param {Painted} edit
   * @param {() => boolean} same whether the clip is still the same
   */
  async carry(corrector, edit, same) {
    const { host } = this;
    const carrying = new AbortController();
    this.carrying = carrying;
    this.offerStop(true);
    const reach = () => plural(edit.frames.length, 'frame');
    try {
      await corrector.carry(edit, carrying.signal, () => same() && host.tell(`Carried to ${reach()}…`));
    } catch (error) {
      if (!carrying.signal.aborted) throw error;
    } finally {
      this.carrying = null;
      this.offerStop(false);
      if (same()) {
        host.show(edit.frames);
        const [first, last] = [Math.min(...edit.frames), Math.max(...edit.frames)];
        host.tell(
          first === last
            ? `In frame ${first + 1} alone: the picture changes too much.`
            : `In ${reach()}, ${first + 1} to ${last + 1}.`,
        );
      }
    }
  }
}

/** A stroke of the package, as it grows. @typedef {import('../library.js').Stroke & {points: number[]}} Stroke */

/** Half the width of the brush in CSS pixels. */
const BRUSH_PX = 7;

/** Points of a stroke are at least this far apart, in CSS pixels. */
const STEP_PX = 2;

const COLOURS = {
  together: ['#ffffff'],
  apart: ['#ff2b3d', '#ffffff', '#3a45c4', '#ffd400'],
  paint: ['#ffffff'],
  erase: ['#16181d'],
};

/** @typedef {keyof typeof COLOURS} StrokeTool */

export class Strokes {
  /**
   * @param {import('../viewer.js').Viewer} viewer
   * @param {() => void} onChange
   * @param {{radius: () => number, paint: (stroke: Stroke, tool: 'paint' | 'erase') => void}} brush what a stroke of it
   *   does at once, and half its width in CSS pixels
   */
  constructor(viewer, onChange, brush) {
    this.viewer = viewer;
    this.onChange = onChange;
    this.brush = brush;
    /** @type {Stroke[]} */
    this.list = [];
    /** @type {StrokeTool | null} */
    this.tool = null;
    /** @type {Stroke | null} The one under the pointer. */
    this.current = null;
    const { canvas } = viewer;
    canvas.addEventListener('pointerdown', (event) => this.begin(event));
    canvas.addEventListener('pointermove', (event) => this.extend(event));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => this.end());
  }

  /** @param {StrokeTool | null} tool null paints nothing */
  use(tool) {
    if (tool !== this.tool) this.list = [];
    this.tool = tool;
    this.current = null;
    this.viewer.canvas.classList.toggle('is-painting', tool !== null);
    this.viewer.redraw();
  }

  clear() {
    this.list = [];
    this.current = null;
    this.onChange();
    this.viewer.redraw();
  }

  /** Half the width of a stroke, in CSS pixels. */
  get radius() {
    return this.tool === 'paint' || this.tool === 'erase' ? this.brush.radius() : BRUSH_PX;
  }

  /** @param {PointerEvent} event */
  begin(event) {
    if (!this.tool || event.button !== 0) return;
    const { canvas, view } = this.viewer;
    canvas.setPointerCapture(event.pointerId);
    this.current = { t: view.frame, points: this.at(event), radius: this.radius * view.unit };
    this.viewer.redraw();
  }

  /** @param {PointerEvent} event */
  extend(event) {
    // The brush's tip goes with the pointer.
    if (this.tool === 'paint' || this.tool === 'erase') this.viewer.redraw();
    if (!this.current) return;
    const { points } = this.current;
    const [x, y] = this.at(event);
    const far = Math.hypot(x - points[points.length - 2], y - points[points.length - 1]);
    if (far < STEP_PX * this.viewer.view.unit) return;
    points.push(x, y);
    this.viewer.redraw();
  }

  end() {
    if (!this.current) return;
    const { current, tool } = this;
    this.current = null;
    if (tool === 'paint' || tool === 'erase') {
      this.brush.paint(current, tool);
      return;
    }
    this.list = [...this.list, current];
    this.onChange();
  }

  /**
   * @param {PointerEvent} event
   * @returns {[x: number, y: number]} clip pixels
   */
  at(event) {
    return this.viewer.placeAt(event);
  }

  /**
   * @param {CanvasRenderingContext2D} ctx scaled to clip pixels
   * @param {import('../layers/layer.js').View} view
   */
  draw(ctx, view) {
    const { tool } = this;
    if (!tool) return;
    const all = this.current ? [...this.list, this.current] : this.list;
    ctx.lineCap = 'round';
    ctx.lineJoin = 'round';
    all.forEach(({ t, points, radius }, k) => {
      const colours = COLOURS[tool];
      for (const [style, width] of /** @type {[string, number][]} */ ([
        ['rgb(0 0 0 / 0.7)', 2 * radius + 3 * view.unit],
        [colours[k % colours.length], 2 * radius],
      ])) {
        // A stroke of another frame is only hinted at.
        ctx.globalAlpha = t === view.frame ? 0.75 : 0.2;
        ctx.strokeStyle = style;
        ctx.lineWidth = width;
        ctx.beginPath();
        ctx.moveTo(points[0], points[1]);
        ctx.lineTo(points[0], points[1]);
        for (let p = 2; p < points.length; p += 2) ctx.lineTo(points[p], points[p + 1]);
        ctx.stroke();
      }
    });
    ctx.globalAlpha = 1;
    if (tool === 'paint' || tool === 'erase') this.drawTip(ctx, view);
  }

  /**
   * How wide the brush is, around the pointer.
   *
   * @param {CanvasRenderingContext2D} ctx
   * @param {import('../layers/layer.js').View} view
   */
  drawTip(ctx, view) {
    const { pointer } = this.viewer;
    if (!pointer) return;
    for (const [style, width] of /** @type {[string, number][]} */ ([
      ['rgb(0 0 0 / 0.7)', 3],
      ['#fff', 1.5],
    ])) {
      ctx.strokeStyle = style;
      ctx.lineWidth = width * view.unit;
      ctx.beginPath();
      ctx.arc(...this.viewer.placeAt(pointer), this.radius * view.unit, 0, 2 * Math.PI);
      ctx.stroke();
    }
  }
}
