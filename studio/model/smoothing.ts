// Masks smoothed over time, in the background, from the frame on screen on.

import { splitShots } from './export.js';
import { type ImageEngine, type MaskSource, createImageEngine, smoothMasks } from './library.js';
import type { Segmentation } from './segmentation.js';
import type { State, Store } from './store.js';

/**
 * Masks that are smoothed, or on their way: `labels` of a frame, null as long as they are not there; `whole` when all are;
 * `done` of `total` frames.
 */
export type SmoothedMasks = {
  labels: (t: number) => Uint8Array | null;
  complete: Promise<MaskSource>;
  done: number;
  total: number;
};

/** Masks that stay as they are for so long are meant, in milliseconds. */
const START_DELAY_MS = 250;

export class Smoothing {
  target: { reach: number; points: unknown } = { reach: 0, points: null };
  abort = new AbortController();
  engine: Promise<ImageEngine> | null = null;

  constructor(readonly store: Store) {
    store.watch(['edges', 'analysis', 'phase'], (state) => this.show(state));
  }

  show({ edges, analysis, phase }: Readonly<State>) {
    const points = phase === 'done' && analysis?.segmentation ? analysis.segmentation : null;
    const reach = points ? edges.smooth : 0;
    if (this.target.reach === reach && (reach === 0 || this.target.points === points)) return;
    this.target = { reach, points };
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
    this.store.set({ smoothedMasks: null });
  }

  begin(reach: number, points: Segmentation) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    /** The masks of frames that are there. */
    const framesDone = new Map<number, MaskSource>();
    // The mask on screen is asked for again and again.
    let last: { t: number; labels: Uint8Array } = { t: -1, labels: new Uint8Array(0) };
    const labels = (t: number) => {
      const masks = framesDone.get(t);
      if (!masks) return null;
      if (last.t !== t) last = { t, labels: masks.labels(t) };
      return last.labels;
    };
    const complete = this.work(reach, points, signal, (t, masks) => {
      framesDone.set(t, masks);
      this.store.set({ smoothedMasks: { ...smoothedMasks, done: (smoothedMasks.done += 1) } });
    });
    const smoothedMasks: SmoothedMasks = { labels, complete, done: 0, total: points.result.numFrames };
    complete.catch((error) => void (signal.aborted || this.fail(error)));
    this.store.set({ smoothedMasks });
  }

  async work(
    reach: number,
    points: Segmentation,
    signal: AbortSignal,
    onFrame: (t: number, masks: MaskSource) => void,
  ) {
    await new Promise((resolve) => setTimeout(resolve, START_DELAY_MS));
    signal.throwIfAborted();
    const { job, timeline, frame } = this.store.state;
    const corrections = job?.corrections;
    if (!corrections) throw new Error('there are no frames');
    const { width, height, numFrames } = points.result;
    const masks = {
      ...{ width, height, numFrames },
      times: timeline.times.seconds?.slice(0, numFrames) ?? null,
      shots: splitShots(timeline, numFrames),
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
    this.target = { reach: 0, points: null };
    const notice = error instanceof Error ? error.message : String(error);
    this.store.set({ smoothedMasks: null, edges: { ...this.store.state.edges, smooth: 0 }, notice });
  }
}
