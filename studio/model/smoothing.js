/** Masks smoothed over time, in the background, from the frame on screen on. @module */

import { shotsOf } from './export.js';
import { createImageEngine, smoothMasks } from './library.js';

/** @typedef {import('./library.js').MaskSource} MaskSource */

/**
 * Masks that are smoothed, or on their way: `labels` of a frame, null as long as they are not there; `whole` when all are;
 * `done` of `total` frames.
 *
 * @typedef {{labels: (t: number) => Uint8Array | null, whole: Promise<MaskSource>, done: number, total: number}} Smoothed
 */

/** Masks that stay as they are for so long are meant, in milliseconds. */
const SETTLED_MS = 250;

export class Smoothing {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store;
    /** @type {{reach: number, points: unknown}} What is smoothed. */
    this.of = { reach: 0, points: null };
    this.abort = new AbortController();
    /** @type {Promise<import('./library.js').ImageEngine> | null} */
    this.engine = null;
    store.watch(['edges', 'found', 'phase'], (state) => this.show(state));
  }

  /** @param {Readonly<import('./store.js').State>} state */
  show({ edges, found, phase }) {
    const points = phase === 'done' && found?.points ? found.points : null;
    const reach = points ? edges.smooth : 0;
    if (this.of.reach === reach && (reach === 0 || this.of.points === points)) return;
    this.of = { reach, points };
    this.abort.abort();
    if (reach > 0) {
      this.begin(reach, /** @type {import('./points.js').Points} */ (points));
      return;
    }
    this.engine?.then(
      (engine) => engine.close(),
      () => {},
    );
    this.engine = null;
    this.store.set({ smoothed: null });
  }

  /**
   * @param {number} reach
   * @param {import('./points.js').Points} points
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
    });
    /** @type {Smoothed} */
    const smoothed = { labels, whole, done: 0, total: points.result.numFrames };
    whole.catch((error) => void (signal.aborted || this.fail(error)));
    this.store.set({ smoothed });
  }

  /**
   * @param {number} reach
   * @param {import('./points.js').Points} points
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
    const notice = error instanceof Error ? error.message : String(error);
    this.store.set({ smoothed: null, edges: { ...this.store.state.edges, smooth: 0 }, notice });
  }
}
