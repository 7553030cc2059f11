// Smooths masks over time in the background, starting at the frame on screen.

import { splitShots } from './export.js';
import { type ImageEngine, type MaskSource, createImageEngine, smoothMasks } from './library.js';
import type { Segmentation } from './presence.js';
import type { State, Store } from './store.js';

/** Smoothed masks: `labels` of a frame is null until it is done; `complete` resolves with all masks. */
export type SmoothedMasks = {
  labels: (t: number) => Uint8Array | null;
  complete: Promise<MaskSource>;
  done: number;
  total: number;
};

/** Time without changes before smoothing starts, in milliseconds; chosen by eye. */
const START_DELAY_MS = 250;

export class Smoothing {
  target: { reach: number; segmentation: unknown } = { reach: 0, segmentation: null };
  abort = new AbortController();
  engine: Promise<ImageEngine> | null = null;

  constructor(readonly store: Store) {
    store.watch(['edges', 'analysis', 'phase'], (state) => this.show(state));
  }

  show({ edges, analysis, phase }: Readonly<State>) {
    const segmentation = phase === 'done' && analysis ? analysis.segmentation : null;
    const reach = segmentation ? edges.smooth : 0;
    if (this.target.reach === reach && (reach === 0 || this.target.segmentation === segmentation)) return;
    this.target = { reach, segmentation: segmentation };
    this.abort.abort();
    if (reach > 0) {
      this.begin(reach, segmentation!);
      return;
    }
    this.engine?.then(
      (engine) => engine.close(),
      () => {},
    );
    this.engine = null;
    this.store.set({ smoothedMasks: null });
  }

  begin(reach: number, segmentation: Segmentation) {
    this.abort = new AbortController();
    const { signal } = this.abort;
    /** Finished masks by frame. */
    const framesDone = new Map<number, MaskSource>();
    // The mask on screen is requested repeatedly.
    let last: { t: number; labels: Uint8Array } = { t: -1, labels: new Uint8Array(0) };
    const labels = (t: number) => {
      const masks = framesDone.get(t);
      if (!masks) return null;
      if (last.t !== t) last = { t, labels: masks.labels(t) };
      return last.labels;
    };
    const complete = this.smooth(reach, segmentation, signal, (t, masks) => {
      framesDone.set(t, masks);
      this.store.set({ smoothedMasks: { ...smoothedMasks, done: (smoothedMasks.done += 1) } });
    });
    const smoothedMasks: SmoothedMasks = { labels, complete, done: 0, total: segmentation.result.numFrames };
    complete.catch((error) => void (signal.aborted || this.fail(error)));
    this.store.set({ smoothedMasks });
  }

  async smooth(
    reach: number,
    segmentation: Segmentation,
    signal: AbortSignal,
    onFrame: (t: number, masks: MaskSource) => void,
  ) {
    await new Promise((resolve) => setTimeout(resolve, START_DELAY_MS));
    signal.throwIfAborted();
    const { job, timeline, frame } = this.store.state;
    const corrections = job?.corrections;
    if (!corrections) throw new Error('there are no frames');
    const { width, height, numFrames } = segmentation.result;
    const masks = {
      ...{ width, height, numFrames },
      times: timeline.times.seconds?.slice(0, numFrames) ?? null,
      shots: splitShots(timeline, numFrames),
      labels: (t: number) => segmentation.mask(t)!,
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
    this.target = { reach: 0, segmentation: null };
    const notice = error instanceof Error ? error.message : String(error);
    this.store.set({ smoothedMasks: null, edges: { ...this.store.state.edges, smooth: 0 }, notice });
  }
}
