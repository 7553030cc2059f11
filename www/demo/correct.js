/**
 * Correcting a result: one object is chosen, by a click or in a list; it is merged, split, or made background, or strokes say what belongs
 * together and what does not. The result changes in place.
 * @module
 */

import { moveOf, nameAndColour, placeName } from './describe.js';
import { byId, h } from './dom.js';
import { objectName } from './palette.js';
import { Strokes } from './strokes.js';
import { explain, percent, seconds } from './words.js';

/** @typedef {import('./layer.js').Spot} Spot */

/**
 * What can be corrected. What a kind of result cannot do is left out.
 *
 * @typedef {object} Corrector
 * @property {(a: number, b: number) => Promise<unknown>} merge
 * @property {(label: number, at?: {t: number, x: number, y: number}) => Promise<unknown>} [split]
 * @property {(strokes: import('./strokes.js').Stroke[]) => Promise<unknown>} [together]
 * @property {(strokes: import('./strokes.js').Stroke[]) => Promise<unknown>} [apart]
 * @property {() => Promise<unknown>} undo
 * @property {() => number} count corrections in force
 */

/** @typedef {'pick' | 'together' | 'apart'} Tool */

export class Correction {
  /** @param {import('./app.js').App} app */
  constructor(app) {
    this.app = app;
    this.on = false;
    this.busy = false;
    /** @type {number} The object that is meant. */
    this.object = 1;
    /** @type {{t: number, x: number, y: number} | null} Where it was clicked. */
    this.place = null;
    /** @type {Tool} */
    this.tool = 'pick';
    this.strokes = new Strokes(app.viewer, () => this.update());
    this.list = /** @type {HTMLSelectElement} */ (byId('correct-object'));
    this.into = /** @type {HTMLSelectElement} */ (byId('correct-into'));
    byId('correct-open').addEventListener('click', () => this.toggle());
    byId('correct-done').addEventListener('click', () => this.toggle(false));
    this.list.addEventListener('change', () => this.choose(Number(this.list.value)));
    byId('correct-merge').addEventListener('click', () => this.apply((c) => c.merge(Number(this.into.value), this.object)));
    byId('correct-background').addEventListener('click', () => this.apply((c) => c.merge(0, this.object)));
    byId('correct-split').addEventListener('click', () => this.apply((c) => c.split?.(this.object, this.place ?? undefined)));
    byId('correct-undo').addEventListener('click', () => this.undo());
    byId('strokes-apply').addEventListener('click', () => this.applyStrokes());
    byId('strokes-clear').addEventListener('click', () => this.strokes.clear());
    for (const radio of this.tools) radio.addEventListener('change', () => this.use(/** @type {Tool} */ (radio.value)));
  }

  /** @returns {HTMLInputElement[]} */
  get tools() {
    return [...byId('correct-tools').querySelectorAll('input')];
  }

  /** @returns {Corrector | null} */
  get corrector() {
    return this.app.points?.hasMasks ? (this.app.job?.corrector ?? null) : null;
  }

  /** @param {boolean} [on] */
  toggle(on = !this.on) {
    this.on = on && this.corrector !== null;
    document.body.toggleAttribute('data-correcting', this.on);
    byId('correct-open').setAttribute('aria-pressed', String(this.on));
    if (this.on) this.app.timeline.pause();
    this.use('pick');
    this.tell('');
    this.fill();
  }

  /** Lists the objects of the result on screen. */
  fill() {
    const { points } = this.app;
    if (!this.on || !points) return;
    const there = this.app.facts.filter(({ object, first }) => object === 0 || first >= 0);
    const options = (/** @type {boolean} */ chosen) =>
      there.map(({ object }) => h('option', { value: object, selected: chosen && object === this.object }, chosen ? nameAndColour(object) : objectName(object)));
    if (!there.some(({ object }) => object === this.object)) this.object = there.find(({ object }) => object > 0)?.object ?? 0;
    this.list.replaceChildren(...options(true));
    this.into.replaceChildren(...options(false));
    this.update();
  }

  /**
   * @param {number} object
   * @param {{t: number, x: number, y: number} | null} [place]
   */
  choose(object, place = null) {
    this.object = object;
    this.place = place;
    this.list.value = String(object);
    this.tell('');
    this.update();
  }

  /** @param {Spot} spot */
  pick({ object, x, y }) {
    if (this.tool === 'pick' && object >= 0 && !this.busy) this.choose(object, { t: this.app.timeline.frame, x, y });
  }

  /** @param {Tool} tool */
  use(tool) {
    this.tool = tool;
    for (const radio of this.tools) radio.checked = radio.value === tool;
    this.strokes.use(this.on && tool !== 'pick' ? tool : null);
    this.update();
  }

  /** Which buttons there are, and the facts of the object that is meant. */
  update() {
    const { app, object, into, tool, strokes } = this;
    const { corrector } = this;
    if (!this.on || !corrector) return;
    for (const option of into.options) option.hidden = option.disabled = Number(option.value) === object;
    if (Number(into.value) === object) into.value = [...into.options].find((option) => !option.disabled)?.value ?? '0';
    const facts = app.facts[object];
    byId('correct-facts').textContent =
      object === 0 ? 'Everything that is no object.' : facts ? `${placeName(facts.from)}, ${moveOf(facts)}, ${percent(facts.share)}` : '';
    byId('correct-split').textContent = object === 0 ? 'Make an object here' : this.place ? 'Split off this part' : 'Split';
    const picking = tool === 'pick';
    byId('correct-actions').hidden = byId('correct-chosen').hidden = !picking;
    byId('stroke-actions').hidden = byId('stroke-help').hidden = picking;
    byId('stroke-help').textContent =
      tool === 'together' ? 'Paint over what is one thing.' : 'Paint over each of the things that are not one: a stroke for each.';
    byId('strokes-count').textContent = `${strokes.list.length} painted`;
    disable('strokes-apply', this.busy || strokes.list.length < (tool === 'apart' ? 2 : 1));
    disable('strokes-clear', this.busy || strokes.list.length === 0);
    disable('correct-merge', this.busy || object === 0);
    disable('correct-into', this.busy || object === 0);
    disable('correct-background', this.busy || object === 0);
    disable('correct-split', this.busy || !corrector.split || (object === 0 && !this.place));
    disable('correct-undo', this.busy || corrector.count() === 0);
    for (const radio of this.tools) radio.disabled = radio.value !== 'pick' && !corrector.together;
    app.viewer.redraw();
  }

  applyStrokes() {
    const { tool } = this;
    const list = this.strokes.list;
    return this.apply((c) => (tool === 'apart' ? c.apart?.(list) : c.together?.(list)));
  }

  undo() {
    if (this.on && (this.corrector?.count() ?? 0) > 0) this.apply((c) => c.undo());
  }

  /** @param {(corrector: Corrector) => Promise<unknown> | undefined} correct */
  async apply(correct) {
    const { app, corrector } = this;
    if (!corrector || this.busy) return;
    const { visit } = app;
    const began = performance.now();
    this.busy = true;
    this.tell('Correcting…');
    this.update();
    try {
      await correct(corrector);
      if (visit !== app.visit) return;
      this.strokes.clear();
      this.place = null;
      app.showCorrected();
      this.tell(`Corrected in ${seconds(performance.now() - began)}. ${app.headline}.`);
    } catch (error) {
      if (visit === app.visit) this.tell(`That is not possible here: ${explain(error).detail}.`, true);
    } finally {
      if (visit === app.visit) {
        this.busy = false;
        this.fill();
      }
    }
  }

  /** A new clip: nothing is chosen any more. */
  leave() {
    this.busy = false;
    this.strokes.clear();
    this.toggle(false);
    this.object = 1;
  }

  /**
   * @param {string} text
   * @param {boolean} [wrong]
   */
  tell(text, wrong = false) {
    byId('correct-status').textContent = text;
    byId('correct-status').classList.toggle('is-wrong', wrong);
  }

  /**
   * Marks the object that is meant, and strokes.
   *
   * @param {CanvasRenderingContext2D} ctx scaled to clip pixels
   * @param {import('./layer.js').View} view
   */
  draw(ctx, view) {
    if (!this.on) return;
    if (this.tool === 'pick' && this.object > 0) drawFrame(ctx, view, boxOf(view, this.object));
    this.strokes.draw(ctx, view);
  }
}

/**
 * @param {string} id
 * @param {boolean} disabled
 */
function disable(id, disabled) {
  /** @type {HTMLButtonElement} */ (byId(id)).disabled = disabled;
}

/**
 * @param {import('./layer.js').View} view
 * @param {number} object
 * @returns {[left: number, top: number, right: number, bottom: number] | null} where it is in the frame, in pixels
 */
function boxOf({ points, frame, width, height }, object) {
  const mask = points?.mask(frame);
  if (!mask) return null;
  let [left, top, right, bottom] = [width, height, -1, -1];
  for (let at = mask.indexOf(object); at >= 0; at = mask.indexOf(object, at + 1)) {
    const x = at % width;
    const y = (at - x) / width;
    if (x < left) left = x;
    if (x > right) right = x;
    if (y < top) top = y;
    bottom = y;
  }
  return right < 0 ? null : [left, top, right, bottom];
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./layer.js').View} view
 * @param {[number, number, number, number] | null} box
 */
function drawFrame(ctx, { unit }, box) {
  if (!box) return;
  const [left, top, right, bottom] = box;
  const room = 4 * unit;
  for (const [style, width, dash] of /** @type {const} */ ([['rgb(0 0 0 / 0.6)', 4, []], ['#fff', 2, [6, 4]]])) {
    ctx.strokeStyle = style;
    ctx.lineWidth = width * unit;
    ctx.setLineDash(dash.map((length) => length * unit));
    ctx.strokeRect(left - room, top - room, right - left + 2 * room, bottom - top + 2 * room);
  }
  ctx.setLineDash([]);
}
