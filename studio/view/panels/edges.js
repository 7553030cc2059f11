/**
 * Edges of masks: how they grow, shrink and fade; and masks smoothed over time, in the background, from the frame on
 * screen on.
 * @module
 */

import { createImageEngine, smoothMasks } from '../library.js';
import { byId } from '../dom.js';
import { DEFAULT_EDGES } from '../saved/look.js';
import { shotsOf } from '../result/export.js';

/** @typedef {import('../saved/look.js').EdgeChoice} EdgeChoice */
/** @typedef {import('../library.js').MaskSource} MaskSource */

/** @type {{[Name in keyof EdgeChoice]: (value: number) => string}} */
const WORDS = {
  smallest: (value) => (value > 0 ? `${value.toFixed(2)}\u00a0%` : 'kept'),
  grow: (value) => (value === 0 ? 'as found' : `${value > 0 ? '+' : '−'}${Math.abs(value)}\u00a0px`),
  feather: (value) => (value > 0 ? `${value}\u00a0px` : 'hard'),
  smooth: (value) => (value > 0 ? `±${value}` : 'off'),
};

/** @param {Pick<import('../page.js').Page, 'store' | 'viewer'>} page */
export function edgesPanel({ store, viewer }) {
  const names = /** @type {(keyof EdgeChoice)[]} */ (Object.keys(WORDS));
  const inputs = names.map((name) => {
    const input = /** @type {HTMLInputElement} */ (byId(`edge-${name}`));
    input.addEventListener('input', () => store.set({ edges: { ...store.state.edges, [name]: Number(input.value) } }));
    return { name, input };
  });
  byId('edges-reset').addEventListener('click', () => store.set({ edges: DEFAULT_EDGES }));
  store.watch(['edges', 'smoothed'], ({ edges, smoothed }) => {
    for (const { name, input } of inputs) {
      const [value, min, max] = [edges[name], Number(input.min), Number(input.max)];
      input.value = String(value);
      input.style.setProperty('--share', String((value - min) / (max - min)));
      input.setAttribute('aria-valuetext', WORDS[name](value));
      byId(`edge-${name}-text`).textContent = WORDS[name](value);
      if (name === 'smooth' && smoothed && smoothed.done < smoothed.total)
        byId('edge-smooth-text').textContent += ` · ${Math.floor((100 * smoothed.done) / smoothed.total)}\u00a0%`;
    }
    byId('edges-reset').hidden = names.every((name) => edges[name] === DEFAULT_EDGES[name]);
    viewer.redraw();
  });
}

/**
 * Masks that are smoothed, or on their way: `labels` of a frame, null as long as they are not there; `whole` when all are;
 * `done` of `total` frames.
 *
 * @typedef {{labels: (t: number) => Uint8Array | null, whole: Promise<MaskSource>, done: number, total: number}} Smoothed
 */

/** Masks that stay as they are for so long are meant, in milliseconds. */
const SETTLED_MS = 250;

/** @param {Pick<import('../page.js').Page, 'store' | 'viewer'>} page */
export function smoothPanel(page) {
  const smoothing = new Smoothing(page);
  page.store.watch(['edges', 'found', 'phase'], (state) => smoothing.show(state));
}

class Smoothing {
  /** @param {Pick<import('../page.js').Page, 'store' | 'viewer'>} page */
  constructor({ store, viewer }) {
    this.store = store;
    this.viewer = viewer;
    /** @type {{reach: number, points: unknown}} What is smoothed. */
    this.of = { reach: 0, points: null };
    this.abort = new AbortController();
    /** @type {Promise<import('../library.js').ImageEngine> | null} */
    this.engine = null;
  }

  /** @param {Readonly<import('../store.js').State>} state */
  show({ edges, found, phase }) {
    const points = phase === 'done' && found?.points ? found.points : null;
    const reach = points ? edges.smooth : 0;
    if (this.of.reach === reach && (reach === 0 || this.of.points === points)) return;
    this.of = { reach, points };
    this.abort.abort();
    if (reach > 0) {
      this.begin(reach, /** @type {import('../result/points.js').Points} */ (points));
      return;
    }
    this.engine?.then(
      (engine) => engine.close(),
      () => {},
    );
    this.engine = null;
    this.store.set({ smoothed: null });
    this.viewer.redraw();
  }

  /**
   * @param {number} reach
   * @param {import('../result/points.js').Points} points
   */
  begin(reach, points) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    /** @type {Map<number, MaskSource>} The masks of frames that are there. */
    const made = new Map();
    // The mask on screen is asked for again and again.
    /** @type {{t: number, labels: Uint8Array}} */
    let last = { t: -1, labels: new Uint8Array(0) };
    const labels = (/** @type {number} */ t) => {
      const masks = made.get(t);
      if (!masks) return null;
      if (last.t !== t) last = { t, labels: masks.labels(t) };
      return last.labels;
    };
    const whole = this.work(reach, points, signal, (t, masks) => {
      made.set(t, masks);
      this.store.set({ smoothed: { ...smoothed, done: (smoothed.done += 1) } });
      this.viewer.redraw();
    });
    /** @type {Smoothed} */
    const smoothed = { labels, whole, done: 0, total: points.result.numFrames };
    whole.catch((error) => void (signal.aborted || this.fail(error)));
    this.store.set({ smoothed });
    this.viewer.redraw();
  }

  /**
   * @param {number} reach
   * @param {import('../result/points.js').Points} points
   * @param {AbortSignal} signal
   * @param {(t: number, masks: MaskSource) => void} onFrame
   */
  async work(reach, points, signal, onFrame) {
    await new Promise((done) => setTimeout(done, SETTLED_MS));
    signal.throwIfAborted();
    const { job, film, frame } = this.store.state;
    const corrections = job?.corrections;
    if (!corrections) throw new Error('there are no frames');
    const { width, height, numFrames } = points.result;
    const masks = {
      ...{ width, height, numFrames },
      times: film.times.seconds?.slice(0, numFrames) ?? null,
      shots: shotsOf(film, numFrames),
      labels: (/** @type {number} */ t) => /** @type {Uint8Array} */ (points.mask(t)),
    };
    this.engine ??= createImageEngine();
    return smoothMasks(masks, {
      reach,
      first: Math.min(frame, numFrames - 1),
      engine: await this.engine,
      picture: (t) => corrections.pixels(t),
      signal,
      onFrame: ({ t, masks: made }) => signal.aborted || onFrame(t, made),
    });
  }

  /** @param {unknown} error */
  fail(error) {
    this.of = { reach: 0, points: null };
    this.store.set({ smoothed: null, edges: { ...this.store.state.edges, smooth: 0 } });
    byId('edge-smooth-text').textContent = error instanceof Error ? error.message : String(error);
  }
}
