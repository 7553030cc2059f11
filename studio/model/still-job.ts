// One run over a single image: no motion, so what is found are boundaries, superpixels and the discontinuities of an
// embedding of its pixels. Each is made in a worker. A cancelled run may be run again and goes on with what is missing.

import { boundaries, imageDiscontinuities, superpixels } from './library.js';
import { STILL, plural } from './words.js';
import { Job, type Shown } from './job.js';
import { type StagePlan, untilAborted } from './stage-clock.js';
import type { Boundaries, ImageEdges, Superpixels } from './answers.js';

const STAGES: StagePlan[] = [
  { id: 'frames', share: 0.02 },
  { id: 'boundaries', share: 0.1 },
  { id: 'superpixels', share: 0.13 },
  { id: 'imageEdges', share: 0.75 },
];

type Finds = { boundaries?: Boundaries; superpixels?: Superpixels; imageEdges?: ImageEdges };

export class StillJob extends Job {
  static stagesFor() {
    return STAGES;
  }

  pixels: ImageData | null = null;
  found: Finds = {};
  /** What is being looked for, a cancelled run's too. */
  asked = new Map<string, Promise<unknown>>();

  constructor(...parts: ConstructorParameters<typeof Job>) {
    super(...parts);
  }

  /**
   * Runs to the end. Rejects with the signal's reason as soon as it is aborted; the worker of that moment ends its work
   * alone.
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
    const find: <K extends keyof Finds>(id: K, make: () => Promise<NonNullable<Finds[K]>>) => Promise<void> = async (
      id,
      make,
    ) => {
      this.found[id] = await this.once(id, make);
      signal.throwIfAborted();
      this.mark(id, 1, 1);
      report();
    };
    await find('boundaries', () => boundaries(pixels));
    await find('superpixels', () => superpixels(pixels, { contour, superpixel }));
    await find('imageEdges', () => imageDiscontinuities(pixels, { still }));
  }

  async read() {
    const pixels = await this.source.preview(0, this.take.side);
    await this.images.add(pixels);
    this.mark('frames', 1, 1);
    return pixels;
  }

  /** Returns the answer of the first call, unless that failed. */
  async once<T>(id: string, make: () => Promise<T>): Promise<T> {
    const answer = (this.asked.get(id) as Promise<T> | undefined) ?? make();
    this.asked.set(id, answer);
    try {
      return await answer;
    } catch (error) {
      this.asked.delete(id);
      throw error;
    }
  }

  get shown(): Shown {
    const { boundaries, superpixels, imageEdges } = this.found;
    return {
      result: null,
      presence: null,
      answers: {
        boundaries: boundaries ? async () => boundaries : null,
        superpixels: superpixels ? async () => superpixels : null,
        imageEdges: imageEdges ? async () => imageEdges : null,
      },
      numbers: [plural(superpixels?.count ?? 0, 'superpixel'), this.size],
      headline: () => STILL.headline,
      notice: () => STILL.remark,
    };
  }
}
