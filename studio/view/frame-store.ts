// The frames of a clip for display. Some are bitmaps in memory, the others JPEG files that are decoded when needed.

import { PageError } from '../model/messages.js';

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
