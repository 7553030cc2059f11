// A lane for each object, in the list of objects: when it is there, and how large.

import { h } from '../dom.js';
import { moveOf, nameAndColour, spanOf } from '../../model/describe.js';
import { objectColor } from '../../model/palette.js';
import { type Store, withinFilm } from '../../model/store.js';
import type { Facts } from '../../model/presence.js';

export class Lanes {
  strips: { canvas: HTMLCanvasElement; object: number }[] = [];

  constructor(
    readonly store: Store,
    list: HTMLElement,
  ) {
    new ResizeObserver(() => this.draw()).observe(list);
  }

  seek(frame: number) {
    this.store.set({ playing: false, frame: withinFilm(this.store.state, frame) });
  }

  /** @returns its lane, which is drawn by `draw` */
  add(facts: Facts): HTMLElement {
    const { object, peak } = facts;
    const { times } = this.store.state.film;
    const span = spanOf(facts, times);
    const where = `${nameAndColour(object)}, ${span}, ${moveOf(facts)}; go to where it is largest, ${times.at(peak)}`;
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
      this.seek(Math.floor(((clientX - left) / width) * this.store.state.film.numFrames));
    };
    strip.setPointerCapture(event.pointerId);
    strip.onpointermove = seek;
    strip.onpointerup = () => (strip.onpointermove = null);
    seek(event);
  }

  /** The height of a lane's bar is the object's size in the frame against its largest size. */
  draw() {
    const { found, film } = this.store.state;
    const presence = found?.points?.presence;
    const { numFrames } = film;
    if (!presence) return;
    const density = devicePixelRatio || 1;
    for (const { canvas, object } of this.strips) {
      const { clientWidth: width, clientHeight: height } = canvas;
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
