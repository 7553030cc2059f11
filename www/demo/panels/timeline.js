/** The timeline: frames, playing, and a lane for each object that says where it is. @module */

import { byId, h } from '../dom.js';
import { withinFilm } from '../store.js';
import { atTime } from '../words.js';
import { say } from '../language.js';
import { moveOf, nameAndColour, spanOf } from '../result/describe.js';
import { objectColor, objectName, objectShape } from '../result/palette.js';

/** @typedef {import('../store.js').Film} Film */
/** @typedef {import('../store.js').State} State */
/** @typedef {import('../result/presence.js').Facts} Facts */
/** @typedef {import('../result/presence.js').Presence} Presence */

/** @param {Pick<import('../page.js').Page, 'store' | 'keys'>} page */
export function timelinePanel({ store, keys }) {
  const timeline = new Timeline(store);
  keys.on(' ', () => timeline.toggle());
  keys.on('ArrowLeft', () => timeline.step(-1));
  keys.on('ArrowRight', () => timeline.step(1));
  keys.on('Home', () => timeline.jump(0));
  keys.on('End', () => timeline.jump(timeline.last));
}

class Timeline {
  /** @param {import('../store.js').Store} store */
  constructor(store) {
    this.store = store;
    this.range = /** @type {HTMLInputElement} */ (byId('scrub'));
    this.lanes = new Lanes((frame) => this.jump(frame));
    this.ticking = 0;
    this.connect();
    store.watch(['film'], ({ film }) => this.showFilm(film));
    store.watch(['found', 'film'], ({ found, film }) => this.lanes.show(found, film));
    store.watch(['frame', 'film'], (state) => this.showFrame(state));
    store.watch(['loop'], ({ loop }) => byId('loop').setAttribute('aria-pressed', String(loop)));
    store.watch(['playing'], ({ playing }) => this.showPlaying(playing));
  }

  connect() {
    this.range.addEventListener('input', () => this.jump(Number(this.range.value)));
    /** @type {Record<string, () => void>} */
    const buttons = {
      play: () => this.toggle(),
      loop: () => this.store.set({ loop: !this.store.state.loop }),
      first: () => this.jump(0),
      back: () => this.step(-1),
      forward: () => this.step(1),
      last: () => this.jump(this.last),
    };
    for (const [id, act] of Object.entries(buttons)) byId(id).addEventListener('click', act);
  }

  /** The last frame. */
  get last() {
    return this.store.state.film.numFrames - 1;
  }

  /** @param {Film} film */
  showFilm({ numFrames, times, cuts }) {
    this.range.max = String(Math.max(0, numFrames - 1));
    for (const control of byId('timeline').querySelectorAll('button, input'))
      /** @type {HTMLButtonElement} */ (control).disabled = numFrames < 2;
    const marks = cuts.map((frame) => {
      const mark = h('span', { class: 'cut', title: say`Cut at ${times.at(frame)}` });
      mark.style.setProperty('--at', String(frame / Math.max(1, numFrames)));
      return mark;
    });
    byId('cuts').replaceChildren(...marks);
    const places = cuts.map((frame) => times.at(frame)).join(', ');
    byId('cuts-text').textContent = cuts.length > 0 ? say`Cuts: ${places}.` : '';
  }

  /** @param {Readonly<State>} state */
  showFrame({ film, frame }) {
    const { numFrames, times } = film;
    // Frames that only just arrive are no film yet.
    const at = withinFilm({ film }, frame);
    this.range.value = String(at);
    this.range.setAttribute('aria-valuetext', say`Frame ${at + 1} of ${numFrames}${atTime(times, at)}`);
    const share = String(numFrames > 1 ? at / (numFrames - 1) : 0);
    this.range.style.setProperty('--share', share);
    this.lanes.list.style.setProperty('--share', share);
    byId('counter').textContent = numFrames > 0 ? `${at + 1} / ${numFrames}` : '– / –';
  }

  /** @param {number} frame */
  jump(frame) {
    this.store.set({ playing: false, frame: withinFilm(this.store.state, frame) });
  }

  /** @param {number} by frames; past either end it stays, or goes round when looping */
  step(by) {
    const { film, frame, loop } = this.store.state;
    if (film.numFrames === 0) return;
    this.jump(loop ? (frame + by + film.numFrames) % film.numFrames : frame + by);
  }

  toggle() {
    const { playing, film, loop, frame } = this.store.state;
    const isAtEnd = !loop && frame === this.last;
    if (playing) this.store.set({ playing: false });
    else if (film.numFrames > 1) this.store.set({ playing: true, frame: isAtEnd ? 0 : frame });
  }

  /** @param {boolean} playing */
  showPlaying(playing) {
    cancelAnimationFrame(this.ticking);
    if (playing) this.play();
    byId('play').dataset.playing = String(playing);
    byId('play').setAttribute('aria-label', playing ? say('Pause') : say('Play'));
  }

  play() {
    let before = performance.now();
    /** For how long the frame on screen has been shown, in seconds. */
    let shown = 0;
    const tick = (/** @type {number} */ now) => {
      this.ticking = requestAnimationFrame(tick);
      const { film, frame } = this.store.state;
      const lasts = (/** @type {number} */ by) => film.times.lasts((frame + by) % film.numFrames, film.fps);
      // A page that was in the background does not try to catch up.
      shown += Math.min((now - before) / 1000, Math.max(1, lasts(0)));
      before = now;
      let due = 0;
      for (; shown >= lasts(due); due++) shown -= lasts(due);
      if (due > 0) this.advance(due);
    };
    this.ticking = requestAnimationFrame(tick);
  }

  /** @param {number} by frames while playing */
  advance(by) {
    const { film, frame, loop } = this.store.state;
    if (!loop && frame + by >= this.last) this.jump(this.last);
    else this.store.set({ frame: (frame + by) % film.numFrames });
  }
}

class Lanes {
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
   * @param {import('../result/presence.js').Times} times
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
