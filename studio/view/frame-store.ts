// The frames of a clip as they are shown. So many lie in memory as pictures, the others as JPEG files that become
// pictures again when they are looked at.

import { PageError } from '../model/words.js';

/** Frames that are kept as pictures. */
const PICTURES = 64;

/** Frames after the one on screen that are made ready, as a clip usually plays forward. */
const AHEAD = 6;

const QUALITY = 0.92;

export class FrameStore {
  length = 0;
  width = 0;
  height = 0;
  /** In the order in which they were last looked at. */
  pictures = new Map<number, ImageBitmap>();
  files = new Map<number, Blob>();
  opening = new Map<number, Promise<ImageBitmap | null>>();
  /** Called when a frame that was asked for has come. */
  onReady = () => {};
  closed = false;

  /** @param most frames kept as pictures */
  constructor(public most: number = PICTURES) {}

  async add(frame: ImageData) {
    const picture = await createImageBitmap(frame);
    const at = this.length;
    this.length += 1;
    [this.width, this.height] = [picture.width, picture.height];
    this.pictures.set(at, picture);
    if (this.length > this.most) await this.pack(at);
  }

  /** @param at goes to a file; its picture may go */
  async pack(at: number) {
    const picture = this.pictures.get(at);
    if (!picture) return;
    this.files.set(at, await fileOf(picture));
    // The first frames too, when there are more than fit.
    const [oldest] = this.pictures.keys();
    if (this.pictures.size > this.most) {
      if (!this.files.has(oldest)) this.files.set(oldest, await fileOf(this.pictures.get(oldest)!));
      this.drop(oldest);
    }
  }

  drop(at: number) {
    this.pictures.get(at)?.close();
    this.pictures.delete(at);
  }

  /**
   * @param more frames after it that are made ready too
   * @returns null as long as it is on its way, and where there is none
   */
  get(at: number, more: number = AHEAD): ImageBitmap | null {
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
    const known = this.pictures.get(at);
    if (known) return Promise.resolve(known);
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
      if (this.pictures.size <= this.most) break;
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

  /** All frames in order; each is there until the next is asked for. */
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

function fileOf(picture: ImageBitmap) {
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  canvas.getContext('2d')?.drawImage(picture, 0, 0);
  return canvas.convertToBlob({ type: 'image/jpeg', quality: QUALITY });
}
