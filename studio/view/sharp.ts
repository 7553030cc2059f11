// The frame on screen as the source has it, read from the file again where the clip rests: as large as the canvas shows
// it, never larger than the source. While a clip plays the frames of the working size do.

import type { AnyJob } from '../model/job.js';

/** A frame that stays on screen for so long is looked at, in milliseconds. */
const REST_MS = 120;

/** Pixels of all pictures that are kept. */
const MOST_PIXELS = 2 ** 25;

type Wanted = { job: AnyJob; frame: number; side: number };

export class Sharp {
  job: AnyJob | null = null;
  /** In the order in which they came. */
  pictures = new Map<number, { picture: ImageBitmap; side: number }>();
  /** Frames that cannot be read. */
  failed = new Set<number>();
  resting = 0;
  /** What is being read. */
  reading: Wanted | null = null;
  /** What is to be read next. */
  next: Wanted | null = null;

  /** @param onReady called when a frame that was wanted has come */
  constructor(public onReady: () => void) {}

  /**
   * @param side that is wanted, in pixels
   * @returns null as long as it is on its way, and where the working size has all there is
   */
  get(job: AnyJob | null, frame: number, side: number): ImageBitmap | null {
    if (job !== this.job) this.clear(job);
    if (!job) return null;
    const known = this.pictures.get(frame);
    const wanted = sideFor(job, side);
    if (wanted > (known?.side ?? job.take.side) && !this.failed.has(frame)) this.want({ job, frame, side: wanted });
    else this.want(null);
    return known?.picture ?? null;
  }

  want(wanted: Wanted | null): null {
    const { next, reading } = this;
    const isSame = (one: Wanted | null) => one?.frame === wanted?.frame && one?.side === wanted?.side;
    if (isSame(next) || (wanted && isSame(reading))) return null;
    this.next = wanted;
    clearTimeout(this.resting);
    if (wanted) this.resting = window.setTimeout(() => this.read(), REST_MS);
    return null;
  }

  /** One after the other: a file is read by one. */
  async read() {
    if (this.reading || !this.next) return;
    const wanted = this.next;
    const { job, frame, side } = wanted;
    Object.assign(this, { reading: wanted, next: null });
    try {
      const { source, take, times } = job;
      const pixels = await source.preview(take.start + frame * take.step, side, times[frame]);
      const picture = await createImageBitmap(pixels);
      if (job === this.job) this.keep(frame, picture, side);
      else picture.close();
    } catch {
      // The frame of the working size stays: asked again, the file would say no again.
      if (job === this.job) this.failed.add(frame);
    } finally {
      this.reading = null;
    }
    if (this.next) this.read();
  }

  keep(frame: number, picture: ImageBitmap, side: number) {
    this.pictures.get(frame)?.picture.close();
    this.pictures.delete(frame);
    this.pictures.set(frame, { picture, side });
    let pixels = 0;
    for (const [at, { picture: one }] of [...this.pictures].reverse()) {
      pixels += one.width * one.height;
      if (pixels <= MOST_PIXELS || at === frame) continue;
      one.close();
      this.pictures.delete(at);
    }
    this.onReady();
  }

  clear(job: AnyJob | null) {
    for (const { picture } of this.pictures.values()) picture.close();
    this.pictures.clear();
    this.failed.clear();
    this.want(null);
    this.job = job;
  }
}

/** Returns the working size, doubled until it is enough; at most the source's. */
function sideFor({ source, take }: AnyJob, side: number): number {
  const whole = Math.max(source.width, source.height);
  let found = Math.min(whole, take.side);
  while (found < Math.min(whole, side)) found = Math.min(whole, 2 * found);
  return found;
}
