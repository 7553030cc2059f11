/**
 * The frames of a clip as they are shown. So many lie in memory as pictures, the others as JPEG files that become
 * pictures again when they are looked at.
 * @module
 */

import { PageError } from '../model/words.js';

/** Frames that are kept as pictures. */
const PICTURES = 64;

/** Frames after the one on screen that are made ready, as a clip usually plays forward. */
const AHEAD = 6;

const QUALITY = 0.92;

export class FrameStore {
  /** @param {number} [most] frames kept as pictures */
  constructor(most = PICTURES) {
    this.most = most;
    this.length = 0;
    this.width = 0;
    this.height = 0;
    /** @type {Map<number, ImageBitmap>} In the order in which they were last looked at. */
    this.pictures = new Map();
    /** @type {Map<number, Blob>} */
    this.files = new Map();
    /** @type {Map<number, Promise<ImageBitmap | null>>} On their way. */
    this.opening = new Map();
    /** Called when a frame that was asked for has come. */
    this.onReady = () => {};
    this.closed = false;
  }

  /** @param {ImageData} frame the next; copied */
  async add(frame) {
    const picture = await createImageBitmap(frame);
    const at = this.length;
    this.length += 1;
    [this.width, this.height] = [picture.width, picture.height];
    this.pictures.set(at, picture);
    if (this.length > this.most) await this.pack(at);
  }

  /** @param {number} at goes to a file; its picture may go */
  async pack(at) {
    const picture = this.pictures.get(at);
    if (!picture) return;
    this.files.set(at, await fileOf(picture));
    // The first frames too, when there are more than fit.
    const [oldest] = this.pictures.keys();
    if (this.pictures.size > this.most) {
      if (!this.files.has(oldest))
        this.files.set(oldest, await fileOf(/** @type {ImageBitmap} */ (this.pictures.get(oldest))));
      this.drop(oldest);
    }
  }

  /** @param {number} at */
  drop(at) {
    this.pictures.get(at)?.close();
    this.pictures.delete(at);
  }

  /**
   * @param {number} at
   * @param {number} [more] frames after it that are made ready too
   * @returns {ImageBitmap | null} null as long as it is on its way, and where there is none
   */
  get(at, more = AHEAD) {
    const picture = this.pictures.get(at) ?? null;
    if (picture) {
      this.pictures.delete(at);
      this.pictures.set(at, picture);
    }
    for (let ahead = at; ahead <= at + more; ahead++)
      if (!this.pictures.has(ahead) && this.files.has(ahead)) this.open(ahead);
    return picture;
  }

  /** @param {number} at */
  has(at) {
    return this.pictures.has(at) || this.files.has(at);
  }

  /**
   * @param {number} at
   * @returns {Promise<ImageBitmap | null>}
   */
  open(at) {
    const known = this.pictures.get(at);
    if (known) return Promise.resolve(known);
    const opening = this.opening.get(at) ?? this.read(at).finally(() => this.opening.delete(at));
    this.opening.set(at, opening);
    return opening;
  }

  /** @param {number} at */
  async read(at) {
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

  /**
   * @param {number} at
   * @param {{width: number, height: number}} size
   * @returns {Promise<ImageData>} of that size
   */
  async pixels(at, { width, height }) {
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

  /** Forgets all frames. */
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

/** @param {ImageBitmap} picture */
function fileOf(picture) {
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  canvas.getContext('2d')?.drawImage(picture, 0, 0);
  return canvas.convertToBlob({ type: 'image/jpeg', quality: QUALITY });
}
