// The lanes in the list of objects, which show when each object appears and how large it is.

import { h } from '../dom.js';
import { describeMotion, nameAndColour, describeSpan } from '../../model/describe.js';
import { objectColor } from '../../model/palette.js';
import { type Store, clampFrame } from '../../model/store.js';
import type { ObjectFacts } from '../../model/presence.js';

export class Lanes {
  strips: { canvas: HTMLCanvasElement; object: number }[] = [];

  constructor(
    readonly store: Store,
    list: HTMLElement,
  ) {
    new ResizeObserver(() => this.draw()).observe(list);
  }

  seek(frame: number) {
    this.store.set({ isPlaying: false, frame: clampFrame(this.store.state, frame) });
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
        { type: 'button', class: 'lane-name', title: where, 'aria-label': where, click: () => this.seek(peak) },
        span,
      ),
    );
  }

  drag(event: PointerEvent, canvas: HTMLCanvasElement) {
    const strip = event.currentTarget as HTMLElement;
    const seek = ({ clientX }: { clientX: number }) => {
      const { left, width } = canvas.getBoundingClientRect();
      this.seek(Math.floor(((clientX - left) / width) * this.store.state.timeline.numFrames));
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
