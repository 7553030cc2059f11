// Full-resolution frames, read from the file again while the clip is paused: as large as the canvas, at most as large
// as the source.

import type { ClipJob } from '../model/clip-job.js';

/** Time on one frame before it is read, in milliseconds; chosen by eye. */
const REST_MS = 120;

/** Largest number of cached pixels; chosen by eye. */
const MOST_PIXELS = 2 ** 25;

type FrameRequest = { job: ClipJob; frame: number; side: number };

export class SharpFrames {
  job: ClipJob | null = null;
  /** Cached frames, oldest first. */
  pictures = new Map<number, { picture: ImageBitmap; side: number }>();
  /** Frames that cannot be read. */
  failed = new Set<number>();
  resting = 0;
  reading: FrameRequest | null = null;
  next: FrameRequest | null = null;

  /** @param onReady called when a requested frame is ready */
  constructor(public onReady: () => void) {}

  /**
   * Returns a frame; null while it is loading, or if the working size is enough.
   * @param side needed long side, in pixels
   */
  get(job: ClipJob | null, frame: number, side: number): ImageBitmap | null {
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

  /** Reads one frame at a time. */
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
      // Keeps the frame of the working size; another attempt would fail too.
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

  clear(job: ClipJob | null) {
    for (const { picture } of this.pictures.values()) picture.close();
    this.pictures.clear();
    this.failed.clear();
    this.schedule(null);
    this.job = job;
  }
}

/** Returns the working size, doubled until it is large enough; at most the source's. */
function sideFor({ source, trim }: ClipJob, side: number): number {
  const fullSide = Math.max(source.width, source.height);
  let result = Math.min(fullSide, trim.side);
  while (result < Math.min(fullSide, side)) result = Math.min(fullSide, 2 * result);
  return result;
}
