// The frames of a clip for display: some are bitmaps in memory, the others JPEG files that are decoded when needed. While the
// clip is paused, frames are read from the file again, as large as the canvas and at most as large as the source.

import { PageError } from '../model/messages.js';
import type { ClipJob } from '../model/clip-job.js';

/** Number of frames kept as bitmaps. */
const MAX_PICTURES = 64;

/** Number of frames decoded ahead of playback; chosen by eye. */
const FRAMES_AHEAD = 6;

const JPEG_QUALITY = 0.92;

export class FrameStore {
  length = 0;
  width = 0;
  height = 0;
  /** Bitmaps by frame, least recently used first. */
  pictures = new Map<number, ImageBitmap>();
  files = new Map<number, Blob>();
  opening = new Map<number, Promise<ImageBitmap | null>>();
  /** Called when a requested frame is ready. */
  onReady = () => {};
  closed = false;

  constructor(public maxPictures: number = MAX_PICTURES) {}

  async add(frame: ImageData) {
    const picture = await createImageBitmap(frame);
    const at = this.length;
    this.length += 1;
    [this.width, this.height] = [picture.width, picture.height];
    this.pictures.set(at, picture);
    if (this.length > this.maxPictures) await this.pack(at);
  }

  /** Compresses a frame and drops the oldest bitmap if there are too many. */
  async pack(at: number) {
    const picture = this.pictures.get(at);
    if (!picture) return;
    this.files.set(at, await encodeJpeg(picture));
    // The first frames are compressed once there are too many.
    const [oldest] = this.pictures.keys();
    if (this.pictures.size > this.maxPictures) {
      if (!this.files.has(oldest)) this.files.set(oldest, await encodeJpeg(this.pictures.get(oldest)!));
      this.drop(oldest);
    }
  }

  drop(at: number) {
    this.pictures.get(at)?.close();
    this.pictures.delete(at);
  }

  /**
   * Returns a frame; null if it is still loading or missing.
   * @param more frames after it to load
   */
  get(at: number, more: number = FRAMES_AHEAD): ImageBitmap | null {
    const picture = this.pictures.get(at) ?? null;
    if (picture) {
      this.pictures.delete(at);
      this.pictures.set(at, picture);
    }
    for (let ahead = at; ahead <= at + more; ahead++)
      if (!this.pictures.has(ahead) && this.files.has(ahead)) this.open(ahead);
    return picture;
  }

  has(at: number) {
    return this.pictures.has(at) || this.files.has(at);
  }

  open(at: number): Promise<ImageBitmap | null> {
    const cached = this.pictures.get(at);
    if (cached) return Promise.resolve(cached);
    const opening = this.opening.get(at) ?? this.read(at).finally(() => this.opening.delete(at));
    this.opening.set(at, opening);
    return opening;
  }

  async read(at: number) {
    const file = this.files.get(at);
    if (!file) return null;
    const picture = await createImageBitmap(file);
    if (this.closed) {
      picture.close();
      return null;
    }
    this.pictures.set(at, picture);
    for (const oldest of this.pictures.keys()) {
      if (this.pictures.size <= this.maxPictures) break;
      if (oldest !== at && this.files.has(oldest)) this.drop(oldest);
    }
    this.onReady();
    return picture;
  }

  async pixels(at: number, { width, height }: { width: number; height: number }): Promise<ImageData> {
    const picture = await this.open(at);
    const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    if (!picture || !context) throw new PageError('closed');
    context.drawImage(picture, 0, 0, width, height);
    return context.getImageData(0, 0, width, height);
  }

  /** Yields all frames in order; each is valid until the next is requested. */
  async *[Symbol.asyncIterator]() {
    for (let at = 0; at < this.length; at++) {
      const picture = await this.open(at);
      if (picture) yield picture;
    }
  }

  clear() {
    for (const at of [...this.pictures.keys()]) this.drop(at);
    this.files.clear();
    this.length = 0;
  }

  close() {
    this.closed = true;
    this.clear();
  }
}

function encodeJpeg(picture: ImageBitmap) {
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  canvas.getContext('2d')?.drawImage(picture, 0, 0);
  return canvas.convertToBlob({ type: 'image/jpeg', quality: JPEG_QUALITY });
}

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
