// The list of objects, each with its lane: its size over time.

import { byId, h, isMultiSelect } from '../dom.js';
import { describeMotion, describePosition, describeSpan, nameAndColour } from '../../model/describe.js';
import { colourName, objectColor, objectName, objectShape } from '../../model/palette.js';
import { listObjects, type Selection } from '../../model/selection.js';
import { formatPercent } from '../../model/messages.js';
import { jumpTo } from '../../model/playback.js';
import type { ObjectFacts } from '../../model/presence.js';
import type { Page } from '../page.js';
import type { Store } from '../../model/store.js';

export function objectsPanel({ store, selection, viewer }: Pick<Page, 'store' | 'selection' | 'viewer'>) {
  let rows: ReturnType<typeof createRow>[] = [];
  const list = byId('object-list');
  const lanes = new Lanes(store, list);
  store.watch(['analysis', 'timeline'], ({ analysis }) => {
    lanes.strips = [];
    rows = listObjects(analysis?.facts ?? []).map((objectFacts) => createRow(objectFacts, selection, lanes));
    list.replaceChildren(...rows.map((row) => row.element));
    lanes.draw();
  });
  store.watch(['analysis', 'timeline', 'hidden', 'selected'], ({ hidden }) => {
    rows.forEach((row) => row.update());
    byId('show-all').hidden = hidden.size === 0;
  });
  byId('show-all').addEventListener('click', () => selection.reset());
  viewer.onPick(({ object }, isMulti) => {
    if (store.state.isCorrecting) return;
    if (isMulti) return selection.toggleSelected(object);
    if (object > 0) selection.isolate(object);
    // A click on the background shows all.
    else if (object === 0) selection.reset();
  });
}

function createRow(facts: ObjectFacts, selection: Selection, lanes: Lanes) {
  const { object, share } = facts;
  const name = objectName(object);
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  const note = h('span', { class: 'visually-hidden' });
  const select = (event: MouseEvent | KeyboardEvent) => {
    event.preventDefault();
    selection.toggleSelected(object);
  };
  const button = h(
    'button',
    {
      ...{ type: 'button', class: 'object-main', title: `Show only ${name}` },
      click: (event: MouseEvent) => (isMultiSelect(event) ? select(event) : selection.isolate(object)),
      // Not every browser reports the shift key of a click by keyboard.
      keydown: (event: KeyboardEvent) => event.key === 'Enter' && event.shiftKey && select(event),
    },
    swatch,
    h('span', { class: 'object-name' }, name, note),
    h('span', { class: 'object-share' }, formatPercent(share)),
    h('span', { class: 'object-facts' }, describeFacts(facts)),
  );
  const element = h('li', { class: 'object', 'data-object': object }, button);
  const keep = object > 0 ? createKeepBox(object, selection) : null;
  if (keep) element.append(keep.element);
  if (object > 0 && facts.first >= 0) element.append(lanes.add(facts));
  const update = () => {
    const isKept = selection.has(object);
    element.classList.toggle('is-hidden', !isKept);
    button.setAttribute('aria-pressed', String(selection.isAlone(object)));
    note.textContent = ` (${colourName(object)})${selection.isSelected(object) ? ', selected' : ''}`;
    keep?.update(isKept);
  };
  return { element, update };
}

function createKeepBox(object: number, selection: Selection) {
  const box = h('input', {
    type: 'checkbox',
    'aria-label': `Keep ${objectName(object)}`,
    change: () => selection.toggle(object),
  });
  const element = h('label', { class: 'keep', title: 'Keep on screen and when saving' }, box);
  const update = (isKept: boolean) => (box.checked = isKept);
  return { element, update };
}

/** Returns `top, moves left`. */
function describeFacts(facts: ObjectFacts): string {
  if (facts.first < 0) return 'not seen';
  return facts.object > 0 ? `${describePosition(facts.from)}, ${describeMotion(facts)}` : '';
}

export class Lanes {
  strips: { canvas: HTMLCanvasElement; object: number }[] = [];

  constructor(
    readonly store: Store,
    list: HTMLElement,
  ) {
    new ResizeObserver(() => this.draw()).observe(list);
  }

  /** Adds the lane of an object; `draw` draws it. */
  add(facts: ObjectFacts): HTMLElement {
    const { object, peak } = facts;
    const { times } = this.store.state.timeline;
    const span = describeSpan(facts, times);
    const where = `${nameAndColour(object)}, ${span}, ${describeMotion(facts)}; go to its largest frame, ${times.format(peak)}`;
    const canvas = h('canvas', { class: 'lane-canvas', 'aria-hidden': 'true' });
    this.strips.push({ canvas, object });
    return h(
      'div',
      { class: 'lane', 'data-lane': object },
      // The scrubber does the same for the keyboard.
      h('div', { class: 'lane-strip', pointerdown: (event) => this.drag(event, canvas) }, canvas),
      h(
        'button',
        {
          type: 'button',
          class: 'lane-name',
          title: where,
          'aria-label': where,
          click: () => jumpTo(this.store, peak),
        },
        span,
      ),
    );
  }

  drag(event: PointerEvent, canvas: HTMLCanvasElement) {
    const strip = event.currentTarget as HTMLElement;
    const seek = ({ clientX }: { clientX: number }) => {
      const { left, width } = canvas.getBoundingClientRect();
      jumpTo(this.store, Math.floor(((clientX - left) / width) * this.store.state.timeline.numFrames));
    };
    strip.setPointerCapture(event.pointerId);
    strip.onpointermove = seek;
    strip.onpointerup = () => (strip.onpointermove = null);
    seek(event);
  }

  /** Draws the lanes: bar heights are sizes relative to the largest size. */
  draw() {
    const { analysis, timeline } = this.store.state;
    const presence = analysis?.segmentation.presence;
    const { numFrames } = timeline;
    if (!presence) return;
    const density = devicePixelRatio || 1;
    // All are measured before one is changed, as each change needs a new layout.
    const lanes = this.strips.map(({ canvas, object }) => {
      return { canvas, object, width: canvas.clientWidth, height: canvas.clientHeight };
    });
    for (const { canvas, object, width, height } of lanes) {
      if (width === 0) continue;
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
      const ctx = canvas.getContext('2d')!;
      ctx.scale(density, density);
      const sizes = Array.from({ length: numFrames }, (_, t) => presence.size(object, t));
      const most = sizes.reduce((a, b) => Math.max(a, b), 1);
      ctx.fillStyle = objectColor(object);
      sizes.forEach((n, t) => {
        if (n === 0) return;
        // Cells meet without a seam: each begins where the last one ends.
        const x = Math.round((t / numFrames) * width);
        const tall = Math.max(2, height * (0.25 + 0.75 * Math.sqrt(n / most)));
        ctx.fillRect(x, (height - tall) / 2, Math.max(1, Math.round(((t + 1) / numFrames) * width) - x), tall);
      });
    }
  }
}
