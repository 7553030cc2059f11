/** One lane per object beneath the scrubber: in which frames it is there, and how large. @module */

import { moveOf, nameAndColour, spanOf } from '../result/describe.js';
import { byId, h } from '../dom.js';
import { objectColor, objectName, objectShape } from '../result/palette.js';
import { say } from '../language.js';

/** @typedef {import('../result/presence.js').Facts} Facts */
/** @typedef {import('../result/presence.js').Presence} Presence */

export class Lanes {
  /** @param {(frame: number) => void} onSeek */
  constructor(onSeek) {
    this.onSeek = onSeek;
    this.list = byId('lanes');
    /** @type {{canvas: HTMLCanvasElement, object: number}[]} */
    this.strips = [];
    /** @type {Presence | null} */
    this.presence = null;
    this.numFrames = 0;
    new ResizeObserver(() => this.draw()).observe(this.list);
  }

  /**
   * @param {import('../store.js').Found | null} found
   * @param {import('../store.js').Film} film frames that are not known yet stay empty
   */
  show(found, { numFrames, times }) {
    this.presence = found?.points?.presence ?? null;
    this.numFrames = numFrames;
    const there = (found?.facts ?? []).filter(({ object, first }) => object > 0 && first >= 0);
    const rows = there.map((one) => this.lane(one, times));
    this.strips = rows.map(({ canvas }, k) => ({ canvas, object: there[k].object }));
    this.list.replaceChildren(...rows.map(({ element }) => element));
    this.list.hidden = rows.length === 0;
    this.draw();
  }

  /**
   * @param {Facts} facts
   * @param {import('../result/times.js').Times} times
   */
  lane(facts, times) {
    const { object, peak } = facts;
    const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
    swatch.style.setProperty('--mark', objectColor(object));
    const what = `${nameAndColour(object)}, ${spanOf(facts, times)}, ${moveOf(facts)}`;
    const where = say`${what}; go to where it is largest, ${times.at(peak)}`;
    const button = h(
      'button',
      { type: 'button', class: 'lane-name', title: where, 'aria-label': where, click: () => this.onSeek(peak) },
      swatch,
      h('span', {}, objectName(object)),
    );
    const canvas = h('canvas', { class: 'lane-canvas', 'aria-hidden': 'true' });
    // The scrubber does the same for the keyboard.
    const strip = h('div', { class: 'lane-strip', pointerdown: (event) => this.drag(event, canvas) }, canvas);
    const element = h(
      'li',
      { class: 'lane', 'data-lane': object },
      button,
      strip,
      h('span', { class: 'lane-time' }, spanOf(facts, times)),
    );
    return { element, canvas };
  }

  /**
   * @param {PointerEvent} event
   * @param {HTMLCanvasElement} canvas
   */
  drag(event, canvas) {
    const strip = /** @type {HTMLElement} */ (event.currentTarget);
    const seek = (/** @type {{clientX: number}} */ { clientX }) => {
      const { left, width } = canvas.getBoundingClientRect();
      const frame = Math.floor(((clientX - left) / width) * this.numFrames);
      this.onSeek(Math.max(0, Math.min(this.numFrames - 1, frame)));
    };
    strip.setPointerCapture(event.pointerId);
    strip.onpointermove = seek;
    strip.onpointerup = () => (strip.onpointermove = null);
    seek(event);
  }

  /** The height of a lane's bar is the object's size in the frame against its largest size. */
  draw() {
    const { presence, numFrames } = this;
    if (!presence) return;
    const density = devicePixelRatio || 1;
    for (const { canvas, object } of this.strips) {
      const { clientWidth: width, clientHeight: height } = canvas;
      if (width === 0) continue;
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
      const ctx = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
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
