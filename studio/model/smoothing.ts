// Masks smoothed over time, in the background, from the frame on screen on.

import { shotsOf } from './export.js';
import { type ImageEngine, type MaskSource, createImageEngine, smoothMasks } from './library.js';
import type { Points } from './points.js';
import type { State, Store } from './store.js';

/**
 * Masks that are smoothed, or on their way: `labels` of a frame, null as long as they are not there; `whole` when all are;
 * `done` of `total` frames.
 */
export type Smoothed = {
  labels: (t: number) => Uint8Array | null;
  whole: Promise<MaskSource>;
  done: number;
  total: number;
};

/** Masks that stay as they are for so long are meant, in milliseconds. */
const SETTLED_MS = 250;

export class Smoothing {
  of: { reach: number; points: unknown } = { reach: 0, points: null };
  abort = new AbortController();
  engine: Promise<ImageEngine> | null = null;

  constructor(readonly store: Store) {
    store.watch(['edges', 'found', 'phase'], (state) => this.show(state));
  }

  show({ edges, found, phase }: Readonly<State>) {
    const points = phase === 'done' && found?.points ? found.points : null;
    const reach = points ? edges.smooth : 0;
    if (this.of.reach === reach && (reach === 0 || this.of.points === points)) return;
    this.of = { reach, points };
    this.abort.abort();
    if (reach > 0) {
      this.begin(reach, points!);
      return;
    }
    this.engine?.then(
      (engine) => engine.close(),
      () => {},
    );
    this.engine = null;
    this.store.set({ smoothed: null });
  }

  begin(reach: number, points: Points) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    /** The masks of frames that are there. */
    const made = new Map<number, MaskSource>();
    // The mask on screen is asked for again and again.
    let last: { t: number; labels: Uint8Array } = { t: -1, labels: new Uint8Array(0) };
    const labels = (t: number) => {
      const masks = made.get(t);
      if (!masks) return null;
      if (last.t !== t) last = { t, labels: masks.labels(t) };
      return last.labels;
    };
    const whole = this.work(reach, points, signal, (t, masks) => {
      made.set(t, masks);
      this.store.set({ smoothed: { ...smoothed, done: (smoothed.done += 1) } });
    });
    const smoothed: Smoothed = { labels, whole, done: 0, total: points.result.numFrames };
    whole.catch((error) => void (signal.aborted || this.fail(error)));
    this.store.set({ smoothed });
  }

  async work(reach: number, points: Points, signal: AbortSignal, onFrame: (t: number, masks: MaskSource) => void) {
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
      labels: (t: number) => points.mask(t)!,
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

  fail(error: unknown) {
    this.of = { reach: 0, points: null };
    const notice = error instanceof Error ? error.message : String(error);
    this.store.set({ smoothed: null, edges: { ...this.store.state.edges, smooth: 0 }, notice });
  }
}
