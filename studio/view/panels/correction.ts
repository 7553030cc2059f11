// The panel of corrections: joins, splits, paints and erases the selected object, adds missing ones, and joins or
// splits by strokes. Every step can be undone and redone. Loaded when first opened.

import { TOUCH, byId, isMultiSelect, h } from '../dom.js';
import { describeMotion, nameAndColour, describePosition } from '../../model/describe.js';
import { objectName } from '../../model/palette.js';
import { listObjects } from '../../model/selection.js';
import { showCorrected } from '../../model/show-result.js';
import { applyStep, possibleSteps } from '../../model/correction-steps.js';
import { formatPercent, formatPlural } from '../../model/messages.js';
import { Brush, type BrushTool, NEW_OBJECT } from '../../model/brush.js';
import { BRUSH_HELP, STROKE_HELP, Strokes, isBrush } from './strokes.js';
import { AddOutline } from './add-outline.js';
import { Crosshair } from './crosshair.js';
import { FixRange } from './fix-range.js';
import { JoinDrag } from './join-drag.js';
import type { Spot } from '../../model/store.js';
import type { Corrections } from '../../model/corrections.js';
import type { ObjectFacts } from '../../model/presence.js';
import type { View } from '../layers.js';
import type { CanvasPlace } from '../viewer.js';
import type { Page } from '../page.js';

type Tool = 'pick' | 'together' | 'apart' | BrushTool;

export class Correction {
  app: Page['app'];
  store: Page['store'];
  viewer: Page['viewer'];
  selection: Page['selection'];
  busy = false;
  object = 1;
  target = 0;
  place: { t: number; x: number; y: number } | null = null;
  tool: Tool = 'pick';
  brush: Brush;
  strokes: Strokes;
  outline: AddOutline;
  crosshair: Crosshair;
  joinDrag: JoinDrag;
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
      appliesToOthers: () => byId<HTMLInputElement>('brush-carry').checked,
      // Disabled, not hidden: the buttons keep their places.
      onCarrying: (isCarrying) => disable('brush-stop', !isCarrying),
      onSizes: (isSmaller, isLarger) => {
        disable('add-smaller', !isSmaller);
        disable('add-larger', !isLarger);
        this.showTool();
      },
      showFrames: (frames) => this.show(frames),
      showStatus: (text, wrong) => this.showStatus(text, wrong),
    });
    this.joinDrag = new JoinDrag(viewer, {
      isOn: () => this.isOpen && this.tool === 'pick' && !this.busy,
      join: (into, other) => this.join(into, [other], `${objectName(other)} joined with ${objectName(into)}`),
    });
    new FixRange(store, this.brush);
    this.strokes = new Strokes(viewer, () => this.update(), {
      radius: () => byId<HTMLInputElement>('brush-size').valueAsNumber / 2,
      paint: (stroke, tool) => this.brush.stroke(stroke, tool),
    });
    this.outline = new AddOutline(
      { store, viewer, keys },
      { corrector: () => this.corrector, object: () => this.object, onChange: () => this.showOutline() },
    );
    this.crosshair = new Crosshair(viewer, keys, {
      move: (place) => this.strokes.extend(place),
      apply: (place, event) => this.applyAt(place, event),
      leave: () => this.strokes.end(),
    });
    this.connect();
    // A tool may have been selected before this file was loaded.
    const checkedTool = this.tools.find(({ checked }) => checked)?.value;
    viewer.painters.push((ctx, view) => this.draw(ctx, view));
    viewer.onPick((spot, isMulti, isRemoving) => this.pick(spot, isMulti, isRemoving));
    const undoable = () => this.isOpen || store.state.previousJob !== null || (this.corrector?.undoCount() ?? 0) > 0;
    const redoable = () => this.isOpen || (this.corrector?.redoCount() ?? 0) > 0;
    keys.on('Ctrl+z', () => this.undo(), undoable);
    for (const key of ['Ctrl+y', 'Ctrl+Shift+z']) keys.on(key, () => this.redo(), redoable);
    keys.on(
      'Escape',
      () => this.toggle(false),
      () => this.isOpen,
    );
    store.watch(['visit'], () => this.reset());
    store.watch(['isCorrecting'], ({ isCorrecting }) => {
      document.body.toggleAttribute('data-correcting', isCorrecting);
      byId('correct-open').setAttribute('aria-pressed', String(isCorrecting));
      viewer.canvas.setAttribute('role', isCorrecting ? 'application' : 'img');
      if (isCorrecting) viewer.canvas.tabIndex = 0;
      else viewer.canvas.removeAttribute('tabindex');
    });
    this.selectTool((checkedTool ?? 'pick') as Tool);
  }

  connect() {
    const buttons: Record<string, () => unknown> = {
      'correct-done': () => this.toggle(false),
      'correct-merge': () => this.join(this.target, [this.object]),
      'correct-background': () => this.join(0, [this.object]),
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
    this.list.addEventListener('change', () => this.selectObject(Number(this.list.value)));
    this.into.addEventListener('change', () => (this.target = Number(this.into.value)));
    for (const radio of this.tools) radio.addEventListener('change', () => this.selectTool(radio.value as Tool));
  }

  get isOpen() {
    return this.store.state.isCorrecting;
  }

  get corrector(): Corrections | null {
    const { analysis, job } = this.store.state;
    return analysis ? (job?.corrector ?? null) : null;
  }

  open() {
    this.toggle();
  }

  toggle(on: boolean = !this.isOpen) {
    const isCorrecting = on && this.corrector !== null;
    const focused = document.activeElement;
    const hadFocus = byId('correct').contains(focused) || focused === this.viewer.canvas;
    this.store.set({ isCorrecting, ...(isCorrecting ? { isPlaying: false } : {}) });
    this.selectTool(isCorrecting ? this.tool : 'pick');
    if (isCorrecting) this.focusTools();
    else if (hadFocus) byId('correct-open').focus();
    this.showStatus('');
    this.listObjects();
  }

  /** Brings the tools into view, and moves the focus to the selected one. */
  focusTools() {
    byId('correct').scrollIntoView({ block: 'nearest' });
    this.tools.find(({ checked }) => checked)?.focus({ preventScroll: true });
  }

  listObjects() {
    const { analysis } = this.store.state;
    if (!this.isOpen || !analysis) return;
    const objects = listObjects(analysis.facts).map(({ object }) => object);
    if (this.createsObjects) objects.push(NEW_OBJECT);
    if (!objects.includes(this.object)) this.object = objects.find((object) => object > 0) ?? 0;
    this.target = 0;
    const optionLabel = (object: number) => (object === NEW_OBJECT ? 'New object' : nameAndColour(object));
    this.list.replaceChildren(...objects.map((object) => h('option', { value: object }, optionLabel(object))));
    // The background has a button of its own.
    const targets = objects.filter((object) => object > 0);
    this.into.replaceChildren(...targets.map((object) => h('option', { value: object }, objectName(object))));
    this.update();
  }

  selectObject(object: number, place: { t: number; x: number; y: number } | null = null) {
    this.object = object;
    this.place = place;
    this.showStatus('');
    this.update();
  }

  /** True if the tool can create objects. */
  get createsObjects() {
    return this.tool === 'paint' || this.tool === 'add';
  }

  /** Selects the object that a tool created or changed. */
  chooseNew(object: number) {
    this.object = object;
    this.listObjects();
  }

  /**
   * Shows a correction.
   * @param frames the changed frames; null for all
   */
  show(frames: number[] | null) {
    showCorrected(this.store, frames);
    this.listObjects();
  }

  /**
   * Handles a click in the picture.
   * @param isMulti true to select several objects
   * @param isRemoving true to remove the region under the pointer
   */
  pick({ object, x, y }: Spot, isMulti: boolean, isRemoving: boolean) {
    if (!this.isOpen || this.busy) return;
    if (this.tool === 'pick' && isMulti) return this.selection.toggleSelected(object);
    if (this.tool === 'add') this.add({ object, x, y }, isRemoving);
    if (this.tool === 'pick' && object >= 0) this.selectObject(object, { t: this.store.state.frame, x, y });
  }

  add({ object, x, y }: Spot, isRemoving: boolean) {
    const region = this.outline.candidates.take(this.store.state.frame, isRemoving);
    return this.brush.add({ x, y }, object, isRemoving, region);
  }

  /** Draws the outlined region of the tool Add, and tells its size. */
  showOutline() {
    const { text } = this.outline;
    byId('add-size').textContent = text && `${text}.`;
    // A pointer shows it by itself.
    if (text && this.crosshair.isShown) this.store.set({ announcement: text });
    this.viewer.redraw();
  }

  /** Applies the tool at the crosshair; strokes begin and end with a key. */
  applyAt(place: CanvasPlace, event: KeyboardEvent) {
    const { strokes } = this;
    if (!strokes.tool) this.pick(this.viewer.spotAt(place), isMultiSelect(event), event.altKey);
    else if (strokes.current) strokes.end();
    else strokes.begin(place);
  }

  selectTool(tool: Tool) {
    if (tool !== this.tool) this.brush.endOffer();
    this.tool = tool;
    for (const radio of this.tools) radio.checked = radio.value === tool;
    this.strokes.selectTool(this.isOpen && tool !== 'pick' && tool !== 'add' ? tool : null);
    this.outline.candidates.turn(this.isOpen && tool === 'add');
    // A missing object is a new one.
    if (tool === 'add') this.object = NEW_OBJECT;
    this.listObjects();
    this.update();
  }

  /** Shows the buttons, and the facts of the selected object. */
  update() {
    const { corrector } = this;
    if (!this.isOpen || !corrector) return;
    this.showChoice();
    this.showTool();
    this.enable(corrector);
    this.viewer.redraw();
  }

  /** Updates the two lists and the facts of the selected object. */
  showChoice() {
    const { object, into } = this;
    const facts = this.store.state.analysis?.facts ?? [];
    if (this.target === object || this.target === 0)
      this.target =
        listObjects(facts).find((candidate) => candidate.object > 0 && candidate.object !== object)?.object ?? 0;
    for (const option of into.options) option.hidden = option.disabled = option.value === String(object);
    into.value = String(this.target);
    this.list.value = String(object);
    byId('correct-facts').textContent =
      object === 0
        ? 'Everything that is not an object.'
        : describeFacts(facts.find((objectFacts) => objectFacts.object === object));
    byId('correct-split').querySelector('.tip')!.textContent =
      object === 0 ? 'Make an object here' : this.place ? 'Split off this part' : 'Split';
  }

  showTool() {
    const { tool, strokes } = this;
    const [picking, brushing] = [tool === 'pick', isBrush(tool)];
    byId('correct-actions').hidden = !picking;
    byId('correct-selected').hidden = !picking && !brushing;
    byId('stroke-actions').hidden = picking || brushing;
    byId('brush-actions').hidden = !brushing;
    byId('brush-width').hidden = tool === 'add';
    // A pointer chooses the size before the click.
    byId('add-sizes').hidden = tool !== 'add' || !(TOUCH || this.brush.offersSizes);
    byId('add-size').hidden = tool !== 'add';
    byId('correct-facts').hidden = !picking;
    byId('stroke-help').hidden = picking && this.into.options.length < 2;
    byId('stroke-help').textContent = isBrush(tool) ? BRUSH_HELP[tool] : STROKE_HELP[tool];
    byId('strokes-count').textContent = formatPlural(strokes.list.length, 'stroke');
  }

  enable(corrector: Corrections) {
    const { busy, object, target, tool } = this;
    const choice = { object, target, tool, hasPlace: this.place !== null, numStrokes: this.strokes.list.length };
    const possible = possibleSteps(corrector, choice, this.store.state.previousJob !== null);
    disable('strokes-apply', busy || !possible.applyStrokes);
    disable('strokes-clear', busy || !possible.clearStrokes);
    for (const id of ['correct-merge', 'correct-into']) disable(id, busy || !possible.join);
    disable('correct-background', busy || !possible.makeBackground);
    disable('correct-split', busy || !possible.split);
    byId('correct-split').title = possible.split ? '' : 'Click the part to split off first';
    disable('correct-undo', busy || !possible.undo);
    disable('correct-redo', busy || !possible.redo);
  }

  /**
   * Joins objects and selects the joined one.
   * @param doneText as of `apply`
   */
  join(into: number, others: number[], doneText?: string) {
    return this.apply(async () => {
      const frames = await this.selection.join(into, others);
      if (into > 0 && others.includes(this.object)) this.object = into;
      return frames;
    }, doneText);
  }

  applyStrokes() {
    const { tool } = this;
    const list = this.strokes.list;
    return this.apply((c) => (tool === 'apart' ? c.splitStrokes(list) : this.selection.joinStrokes(list)));
  }

  async undo() {
    await this.brush.finish();
    // The first step may be the run that replaced another result.
    if (!this.corrector?.undoCount()) await this.app.restore();
    else await this.apply(() => this.selection.undo(), 'Undone');
  }

  async redo() {
    await this.brush.finish();
    if ((this.corrector?.redoCount() ?? 0) > 0) await this.apply(() => this.selection.redo(), 'Redone');
  }

  /**
   * Applies a correction and shows it.
   * @param correct resolves to the changed frames
   * @param doneText status shown instead of the elapsed time
   */
  async apply(correct: (corrector: Corrections) => Promise<number[] | null>, doneText?: string) {
    const { store, corrector } = this;
    if (!corrector || this.busy) return;
    this.busy = true;
    this.showStatus('Correcting…');
    this.update();
    const outcome = await applyStep(store, () => correct(corrector), doneText);
    if (!outcome) return;
    if (!outcome.isError) {
      this.strokes.clear();
      this.place = null;
    }
    this.showStatus(outcome.text, outcome.isError);
    this.busy = false;
    this.listObjects();
  }

  /** Resets the panel for another clip. */
  reset() {
    this.busy = false;
    this.brush.stop();
    this.strokes.clear();
    this.selectTool('pick');
    this.showStatus('');
    this.object = 1;
  }

  showStatus(text: string, isError = false) {
    byId('correct-status').textContent = text;
    byId('correct-status').classList.toggle('is-error', isError);
  }

  /**
   * Draws the box of the selected object, and the strokes.
   * @param ctx scaled to clip pixels
   */
  draw(ctx: CanvasRenderingContext2D, view: View) {
    if (!this.isOpen) return;
    const hasBox = (this.tool === 'pick' || this.tool === 'erase') && this.object > 0;
    const { marked } = this.joinDrag;
    const boxed = marked.length > 0 || !hasBox ? marked : [this.object];
    for (const object of boxed) drawBox(ctx, view, boundingBox(view, object));
    this.joinDrag.draw(ctx, view);
    this.strokes.draw(ctx, view);
    if (this.tool === 'add') this.outline.draw(ctx, view);
  }
}

function describeFacts(facts: ObjectFacts | undefined): string {
  return facts ? `${describePosition(facts.from)}, ${describeMotion(facts)}, ${formatPercent(facts.share)}` : '';
}

function disable(id: string, disabled: boolean) {
  byId<HTMLButtonElement>(id).disabled = disabled;
}

/** Returns the bounding box of an object in pixels; null if it is not in the frame. */
export function boundingBox(
  { segmentation, frame, width, height, mask: edged, visible }: View,
  object: number,
): [left: number, top: number, right: number, bottom: number] | null {
  // Removed specks do not count.
  const mask = (visible(object) && edged()?.labels) || segmentation?.mask(frame);
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

export function drawBox(ctx: CanvasRenderingContext2D, { unit }: View, box: [number, number, number, number] | null) {
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
