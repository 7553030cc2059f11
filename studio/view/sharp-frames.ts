// The frame on screen as the source has it, read from the file again where the clip rests: as large as the canvas shows
// it, never larger than the source. While a clip plays the frames of the working size do.

import type { AnyJob } from '../model/job.js';

/** A frame that stays on screen for so long is looked at, in milliseconds. */
const REST_MS = 120;

/** Pixels of all pictures that are kept. */
const MOST_PIXELS = 2 ** 25;

type FrameRequest = { job: AnyJob; frame: number; side: number };

export class SharpFrames {
  job: AnyJob | null = null;
  /** In the order in which they came. */
  pictures = new Map<number, { picture: ImageBitmap; side: number }>();
  /** Frames that cannot be read. */
  failed = new Set<number>();
  resting = 0;
  /** What is being read. */
  reading: FrameRequest | null = null;
  /** What is to be read next. */
  next: FrameRequest | null = null;

  /** @param onReady called when a frame that was wanted has come */
  constructor(public onReady: () => void) {}

  /**
   * @param side that is wanted, in pixels
   * @returns null as long as it is on its way, and where the working size has all there is
   */
  get(job: AnyJob | null, frame: number, side: number): ImageBitmap | null {
    if (job !== this.job) this.clear(job);
    if (!job) return null;
    const cached = this.pictures.get(frame);
    const neededSide = sideFor(job, side);
    if (neededSide > (cached?.side ?? job.trim.side) && !this.failed.has(frame))
      this.schedule({ job, frame, side: neededSide });
    else this.schedule(null);
    return cached?.picture ?? null;
  }

  schedule(request: FrameRequest | null): null {
    const { next, reading } = this;
    const isSame = (other: FrameRequest | null) => other?.frame === request?.frame && other?.side === request?.side;
    if (isSame(next) || (request && isSame(reading))) return null;
    this.next = request;
    clearTimeout(this.resting);
    if (request) this.resting = window.setTimeout(() => this.read(), REST_MS);
    return null;
  }

  /** One after the other: a file is read by one. */
  async read() {
    if (this.reading || !this.next) return;
    const request = this.next;
    const { job, frame, side } = request;
    Object.assign(this, { reading: request, next: null });
    try {
      const { source, trim, times } = job;
      const pixels = await source.preview(trim.start + frame * trim.step, side, times[frame]);
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
    for (const [at, { picture: cached }] of [...this.pictures].reverse()) {
      pixels += cached.width * cached.height;
      if (pixels <= MOST_PIXELS || at === frame) continue;
      cached.close();
      this.pictures.delete(at);
    }
    this.onReady();
  }

  clear(job: AnyJob | null) {
    for (const { picture } of this.pictures.values()) picture.close();
    this.pictures.clear();
    this.failed.clear();
    this.schedule(null);
    this.job = job;
  }
}

/** Returns the working size, doubled until it is enough; at most the source's. */
function sideFor({ source, trim }: AnyJob, side: number): number {
  const fullSide = Math.max(source.width, source.height);
  let result = Math.min(fullSide, trim.side);
  while (result < Math.min(fullSide, side)) result = Math.min(fullSide, 2 * result);
  return result;
}
