// Correcting a result: one object is chosen, by a click or in a list; it is merged, split, made background, painted or
// wiped away, what was missed is added, or strokes say what belongs together and what does not. The result changes in
// place; every step can be undone and done again. Fetched when it is first opened.

import { byId, h } from '../dom.js';
import { moveOf, nameAndColour, placeName } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import { listed } from '../../model/selection.js';
import { showCorrected } from '../../model/show-result.js';
import { explain, percent, seconds } from '../../model/words.js';
import { Brush, type BrushTool, NEW_OBJECT } from '../../model/brush.js';
import { BRUSH_HELP, Strokes, isBrush } from './strokes.js';
import type { Spot } from '../../model/answers.js';
import type { Corrections } from '../../model/corrections.js';
import type { Facts } from '../../model/presence.js';
import type { View } from '../layers/layer.js';
import type { Page } from '../page.js';

type Tool = 'pick' | 'together' | 'apart' | BrushTool;

export class Correction {
  app: Page['app'];
  store: Page['store'];
  viewer: Page['viewer'];
  selection: Page['selection'];
  busy = false;
  /** The object that is meant. */
  object = 1;
  /** The object that it would be merged with. */
  other = 0;
  /** Where it was clicked. */
  place: { t: number; x: number; y: number } | null = null;
  tool: Tool = 'pick';
  brush: Brush;
  strokes: Strokes;
  list = byId<HTMLSelectElement>('correct-object');
  into = byId<HTMLSelectElement>('correct-into');
  tools: HTMLInputElement[] = [...byId('correct-tools').querySelectorAll('input')];

  constructor({ app, store, viewer, keys, selection }: Pick<Page, 'app' | 'store' | 'viewer' | 'keys' | 'selection'>) {
    this.app = app;
    this.store = store;
    this.viewer = viewer;
    this.selection = selection;
    this.brush = new Brush({
      store,
      corrector: () => this.corrector,
      object: () => this.object,
      choose: (object) => this.chooseNew(object),
      carries: () => byId<HTMLInputElement>('brush-carry').checked,
      // The buttons keep their places.
      tellCarrying: (isCarrying) => disable('brush-stop', !isCarrying),
      tellSizes: (isSmaller, isLarger) => {
        disable('add-smaller', !isSmaller);
        disable('add-larger', !isLarger);
      },
      show: (frames) => this.show(frames),
      tell: (text, wrong) => this.tell(text, wrong),
    });
    this.strokes = new Strokes(viewer, () => this.update(), {
      radius: () => byId<HTMLInputElement>('brush-size').valueAsNumber / 2,
      paint: (stroke, tool) => this.brush.stroke(stroke, tool),
    });
    this.connect();
    // Who opens it may have chosen a tool before it was fetched.
    const chosen = this.tools.find(({ checked }) => checked)?.value;
    viewer.painters.push((ctx, view) => this.draw(ctx, view));
    viewer.onPick((spot, more, away) => this.pick(spot, more, away));
    const undoable = () => this.on || store.state.before !== null || (this.corrector?.count() ?? 0) > 0;
    const redoable = () => this.on || (this.corrector?.redoable() ?? 0) > 0;
    keys.on('Ctrl+z', () => this.undo(), undoable);
    for (const key of ['Ctrl+y', 'Ctrl+Shift+z']) keys.on(key, () => this.redo(), redoable);
    store.watch(['visit'], () => this.leave());
    store.watch(['correcting'], ({ correcting }) => {
      document.body.toggleAttribute('data-correcting', correcting);
      byId('correct-open').setAttribute('aria-pressed', String(correcting));
    });
    this.use((chosen ?? 'pick') as Tool);
  }

  connect() {
    const buttons: Record<string, () => unknown> = {
      'correct-done': () => this.toggle(false),
      'correct-merge': () => this.apply((c) => c.join(this.other, [this.object])),
      'correct-background': () => this.apply((c) => c.join(0, [this.object])),
      'correct-split': () => this.apply((c) => c.split(this.object, this.place ?? undefined)),
      'correct-undo': () => this.undo(),
      'correct-redo': () => this.redo(),
      'brush-stop': () => this.brush.stop(),
      'add-smaller': () => this.brush.resize(-1),
      'add-larger': () => this.brush.resize(1),
      'strokes-apply': () => this.applyStrokes(),
      'strokes-clear': () => this.strokes.clear(),
    };
    for (const [id, act] of Object.entries(buttons)) byId(id).addEventListener('click', act);
    this.list.addEventListener('change', () => this.choose(Number(this.list.value)));
    this.into.addEventListener('change', () => (this.other = Number(this.into.value)));
    for (const radio of this.tools) radio.addEventListener('change', () => this.use(radio.value as Tool));
  }

  get on() {
    return this.store.state.correcting;
  }

  get corrector(): Corrections | null {
    const { found, job } = this.store.state;
    return found?.points ? (job?.corrector ?? null) : null;
  }

  open() {
    this.toggle();
  }

  toggle(on: boolean = !this.on) {
    const correcting = on && this.corrector !== null;
    this.store.set({ correcting, ...(correcting ? { playing: false } : {}) });
    // The tools come first in it.
    if (correcting) byId('panel').scrollTop = 0;
    this.use(correcting ? this.tool : 'pick');
    this.tell('');
    this.fill();
  }

  /** Lists the objects of the result on screen. */
  fill() {
    const { found } = this.store.state;
    if (!this.on || !found) return;
    const objects = listed(found.facts).map(({ object }) => object);
    if (this.makesNew) objects.push(NEW_OBJECT);
    if (!objects.includes(this.object)) this.object = objects.find((object) => object > 0) ?? 0;
    this.other = 0;
    const called = (object: number) => (object === NEW_OBJECT ? 'New object' : nameAndColour(object));
    this.list.replaceChildren(...objects.map((object) => h('option', { value: object }, called(object))));
    // What becomes background has a button of its own.
    const others = objects.filter((object) => object > 0);
    this.into.replaceChildren(...others.map((object) => h('option', { value: object }, objectName(object))));
    this.update();
  }

  choose(object: number, place: { t: number; x: number; y: number } | null = null) {
    this.object = object;
    this.place = place;
    this.tell('');
    this.update();
  }

  /** Whether the tool can begin an object. */
  get makesNew() {
    return this.tool === 'paint' || this.tool === 'add';
  }

  /** An object that a tool has made or gone on with. */
  chooseNew(object: number) {
    this.object = object;
    this.fill();
  }

  /**
   * Shows what was done by hand.
   * @param frames those that changed, null for all
   */
  show(frames: number[] | null) {
    showCorrected(this.store, frames);
    this.fill();
  }

  /**
   * @param more whether it is chosen with others
   * @param away whether what is there is taken away
   */
  pick({ object, x, y }: Spot, more: boolean, away: boolean) {
    if (!this.on || this.busy) return;
    if (this.tool === 'pick' && more) return this.selection.choose(object);
    if (this.tool === 'add') this.brush.add({ x, y }, object, away);
    if (this.tool === 'pick' && object >= 0) this.choose(object, { t: this.store.state.frame, x, y });
  }

  use(tool: Tool) {
    this.tool = tool;
    for (const radio of this.tools) radio.checked = radio.value === tool;
    this.strokes.use(this.on && tool !== 'pick' && tool !== 'add' ? tool : null);
    // A thing that was missed is a new one.
    if (tool === 'add') this.object = NEW_OBJECT;
    this.fill();
    this.update();
  }

  /** Which buttons there are, and the facts of the object that is meant. */
  update() {
    const { corrector } = this;
    if (!this.on || !corrector) return;
    this.showChoice();
    this.showTool();
    this.enable(corrector);
    this.viewer.redraw();
  }

  /** The two lists, and what is known of the object that is meant. */
  showChoice() {
    const { object, into } = this;
    const facts = this.store.state.found?.facts ?? [];
    if (this.other === object || this.other === 0)
      this.other = listed(facts).find((one) => one.object > 0 && one.object !== object)?.object ?? 0;
    for (const option of into.options) option.hidden = option.disabled = option.value === String(object);
    into.value = String(this.other);
    this.list.value = String(object);
    byId('correct-facts').textContent =
      object === 0 ? 'Everything that is no object.' : factsText(facts.find((one) => one.object === object));
    byId('correct-split').textContent =
      object === 0 ? 'Make an object here' : this.place ? 'Split off this part' : 'Split';
  }

  showTool() {
    const { tool, strokes } = this;
    const [picking, brushing] = [tool === 'pick', isBrush(tool)];
    byId('correct-actions').hidden = !picking;
    byId('correct-chosen').hidden = !picking && !brushing;
    byId('stroke-actions').hidden = picking || brushing;
    byId('brush-actions').hidden = !brushing;
    byId('brush-width').hidden = tool === 'add';
    byId('add-sizes').hidden = tool !== 'add';
    byId('stroke-help').hidden = picking;
    byId('stroke-help').textContent = isBrush(tool)
      ? BRUSH_HELP[tool]
      : tool === 'together'
        ? 'Paint over what is one thing.'
        : 'Paint over each of the things that are not one: a stroke for each.';
    byId('strokes-count').textContent = `${strokes.list.length} painted`;
  }

  enable(corrector: Corrections) {
    const { busy, object, tool, strokes } = this;
    disable('strokes-apply', busy || strokes.list.length < (tool === 'apart' ? 2 : 1));
    disable('strokes-clear', busy || strokes.list.length === 0);
    for (const id of ['correct-merge', 'correct-into']) disable(id, busy || object === 0 || this.other === 0);
    disable('correct-background', busy || object === 0);
    const lacksPlace = !this.place && (object === 0 || corrector.splitsAtPlace);
    const noPart = object === 0 && corrector.splitsAtPlace;
    disable('correct-split', busy || lacksPlace || noPart);
    byId('correct-split').title =
      lacksPlace || noPart ? 'Click the part of the object that is another thing first' : '';
    disable('correct-undo', busy || (corrector.count() === 0 && !this.store.state.before));
    disable('correct-redo', busy || corrector.redoable() === 0);
  }

  applyStrokes() {
    const { tool } = this;
    const list = this.strokes.list;
    return this.apply((c) => (tool === 'apart' ? c.apart(list) : c.together(list)));
  }

  async undo() {
    await this.brush.settled();
    // The first step may be the run that took the place of others.
    if (!this.corrector?.count()) await this.app.restore();
    else await this.apply((c) => c.undo(), 'Undone');
  }

  async redo() {
    await this.brush.settled();
    if ((this.corrector?.redoable() ?? 0) > 0) await this.apply((c) => c.redo(), 'Done again');
  }

  /**
   * @param correct gives the frames that change
   * @param done what is told then, in place of the time that it took
   */
  async apply(correct: (corrector: Corrections) => Promise<number[] | null>, done?: string) {
    const { store, corrector } = this;
    if (!corrector || this.busy) return;
    const { visit } = store.state;
    const began = performance.now();
    this.busy = true;
    this.tell('Correcting…');
    this.update();
    try {
      const frames = await correct(corrector);
      if (visit !== store.state.visit) return;
      this.strokes.clear();
      this.place = null;
      showCorrected(store, frames ?? null);
      const words = done ?? `Corrected in ${seconds(performance.now() - began)}`;
      this.tell(`${words}. ${store.state.headline}.`);
    } catch (error) {
      const { title, detail } = explain(error);
      if (visit === store.state.visit) this.tell(`That is not possible here: ${detail || title}.`, true);
    } finally {
      if (visit === store.state.visit) {
        this.busy = false;
        this.fill();
      }
    }
  }

  /** A new clip: nothing is chosen any more. */
  leave() {
    this.busy = false;
    this.brush.stop();
    this.strokes.clear();
    this.use('pick');
    this.tell('');
    this.object = 1;
  }

  tell(text: string, wrong = false) {
    byId('correct-status').textContent = text;
    byId('correct-status').classList.toggle('is-wrong', wrong);
  }

  /**
   * Marks the object that is meant, and strokes.
   * @param ctx scaled to clip pixels
   */
  draw(ctx: CanvasRenderingContext2D, view: View) {
    if (!this.on) return;
    if ((this.tool === 'pick' || this.tool === 'erase') && this.object > 0)
      drawFrame(ctx, view, boxOf(view, this.object));
    this.strokes.draw(ctx, view);
  }
}

function factsText(facts: Facts | undefined): string {
  return facts ? `${placeName(facts.from)}, ${moveOf(facts)}, ${percent(facts.share)}` : '';
}

function disable(id: string, disabled: boolean) {
  byId<HTMLButtonElement>(id).disabled = disabled;
}

/** Returns the place in the frame, in pixels. */
export function boxOf(
  { points, frame, width, height, mask: edged, visible }: View,
  object: number,
): [left: number, top: number, right: number, bottom: number] | null {
  // Specks that are not on screen do not count.
  const mask = (visible(object) && edged()?.labels) || points?.mask(frame);
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

export function drawFrame(ctx: CanvasRenderingContext2D, { unit }: View, box: [number, number, number, number] | null) {
  if (!box) return;
  const [left, top, right, bottom] = box;
  const room = 4 * unit;
  for (const [style, width, dash] of [
    ['rgb(0 0 0 / 0.6)', 4, []],
    ['#fff', 2, [6, 4]],
  ] as const) {
    ctx.strokeStyle = style;
    ctx.lineWidth = width * unit;
    ctx.setLineDash(dash.map((length) => length * unit));
    ctx.strokeRect(left - room, top - room, right - left + 2 * room, bottom - top + 2 * room);
  }
  ctx.setLineDash([]);
}
