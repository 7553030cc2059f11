// A run over a single image, which gives boundaries, superpixels and discontinuities of the embedding, each computed
// in a worker. A cancelled run continues with what is missing.

import { boundaries, imageDiscontinuities, superpixels } from './library.js';
import { STILL_MESSAGES, formatPlural } from './messages.js';
import { Job, type JobView } from './job.js';
import { untilAborted } from './slices.js';
import { type StagePlan } from './library.js';
import type { Boundaries, ImageEdges, Superpixels } from './frame-data.js';

const STAGES: StagePlan[] = [
  { id: 'frames', cost: 0.02 },
  { id: 'boundaries', cost: 0.1 },
  { id: 'superpixels', cost: 0.13 },
  { id: 'imageEdges', cost: 0.75 },
];

type StillOutputs = { boundaries?: Boundaries; superpixels?: Superpixels; imageEdges?: ImageEdges };

export class StillJob extends Job {
  static stages = STAGES;

  pixels: ImageData | null = null;
  outputs: StillOutputs = {};
  /** Running computations, also from a cancelled run. */
  pending = new Map<string, Promise<unknown>>();

  /**
   * Runs to the end. Rejects with the signal's reason when aborted; the current worker still finishes.
   * @param report called after each step
   */
  run(signal: AbortSignal, report: () => void) {
    return untilAborted(this.work(signal, report), signal);
  }

  async work(signal: AbortSignal, report: () => void) {
    this.start();
    this.pixels ??= await this.read();
    signal.throwIfAborted();
    report();
    const { pixels } = this;
    const { contour, superpixel, still } = this.options;
    const computeStage: <K extends keyof StillOutputs>(
      id: K,
      make: () => Promise<NonNullable<StillOutputs[K]>>,
    ) => Promise<void> = async (id, make) => {
      this.outputs[id] = await this.once(id, make);
      signal.throwIfAborted();
      this.mark(id, 1, 1);
      report();
    };
    await computeStage('boundaries', () => boundaries(pixels));
    await computeStage('superpixels', () => superpixels(pixels, { contour, superpixel }));
    await computeStage('imageEdges', () => imageDiscontinuities(pixels, { still }));
  }

  async read() {
    const pixels = await this.source.preview(0, this.trim.side);
    await this.images.add(pixels);
    this.mark('frames', 1, 1);
    return pixels;
  }

  /** Computes a value once; failed calls are repeated. */
  async once<T>(id: string, make: () => Promise<T>): Promise<T> {
    const answer = (this.pending.get(id) as Promise<T> | undefined) ?? make();
    this.pending.set(id, answer);
    try {
      return await answer;
    } catch (error) {
      this.pending.delete(id);
      throw error;
    }
  }

  get shown(): JobView {
    const { boundaries, superpixels, imageEdges } = this.outputs;
    return {
      result: null,
      presence: null,
      frameData: {
        boundaries: boundaries ? async () => boundaries : null,
        superpixels: superpixels ? async () => superpixels : null,
        imageEdges: imageEdges ? async () => imageEdges : null,
      },
      numbers: [formatPlural(superpixels?.count ?? 0, 'superpixel'), this.sizeText],
      headline: () => STILL_MESSAGES.headline,
      notice: () => STILL_MESSAGES.remark,
    };
  }
}
