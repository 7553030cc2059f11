/**
 * A video that is transparent: WebM keeps the alpha of each frame as a second picture beside the first, whose
 * brightness it is. Both are encoded here and not by the muxer's library, because that splits frames in a worker of its
 * own making, which a strict content security policy forbids.
 */

import { TraceCutError } from '../errors.js';

const CODEC_STRING = { vp9: 'vp09.00.51.08', vp8: 'vp8' };

/** Frames from one key frame to the next, at most. */
const KEY_FRAMES = 50;

/** Frames on their way through an encoder before more are painted. */
const MOST_WAITING = 4;

const MICROSECONDS = 1e6;

/**
 * Takes a coded picture and the coded alpha that belongs to it. @typedef {(color: EncodedVideoChunk, alpha: Uint8Array,
 * meta?: EncodedVideoChunkMetadata) => Promise<void>} WritePair
 */

/** Encodes what a painter has painted, colours and alpha, and hands both on together. */
export class AlphaEncoder {
  /**
   * @param {import('./video-painter.js').Painter} painter
   * @param {{codec: 'vp9' | 'vp8', bitrate: number}} config bitrate of each of the two, in bits a second
   * @param {WritePair} write
   */
  constructor(painter, config, write) {
    this.painter = painter;
    this.write = write;
    /** @type {unknown} */
    this.failure = null;
    this.count = 0;
    /** @type {Promise<void>} */
    this.written = Promise.resolve();
    /** @type {[EncodedVideoChunk, EncodedVideoChunkMetadata | undefined][]} */
    this.colors = [];
    /** @type {EncodedVideoChunk[]} */
    this.alphas = [];
    this.color = this.encoder(config, (chunk, meta) => this.colors.push([chunk, meta]));
    this.alpha = this.encoder(config, (chunk) => this.alphas.push(chunk));
  }

  /**
   * @param {{codec: 'vp9' | 'vp8', bitrate: number}} config
   * @param {(chunk: EncodedVideoChunk, meta?: EncodedVideoChunkMetadata) => void} take
   */
  encoder({ codec, bitrate }, take) {
    const { width, height } = this.painter.canvas;
    const encoder = new VideoEncoder({
      output: (chunk, meta) => {
        take(chunk, meta);
        this.pair();
      },
      error: (error) => (this.failure ??= error),
    });
    encoder.configure({ codec: CODEC_STRING[codec], width, height, bitrate, latencyMode: 'quality', alpha: 'discard' });
    return encoder;
  }

  /**
   * @param {number} time in seconds
   * @param {number} duration
   */
  async add(time, duration) {
    const keyFrame = this.count % KEY_FRAMES === 0;
    this.count += 1;
    const init = { timestamp: Math.round(time * MICROSECONDS), duration: Math.round(duration * MICROSECONDS) };
    encode(this.color, new VideoFrame(this.painter.canvas, { ...init, alpha: 'discard' }), keyFrame);
    const { width, height } = this.painter.size;
    encode(
      this.alpha,
      new VideoFrame(brightness(this.painter.alpha(), width, height), {
        ...init,
        format: 'I420',
        codedWidth: width,
        codedHeight: height,
      }),
      keyFrame,
    );
    for (const encoder of [this.color, this.alpha]) {
      while (encoder.encodeQueueSize > MOST_WAITING && !this.failure)
        await new Promise((done) => encoder.addEventListener('dequeue', done, { once: true }));
    }
    await this.written;
    this.check();
  }

  /** Hands on what has come of both; encoders keep the order. */
  pair() {
    while (this.colors.length > 0 && this.alphas.length > 0) {
      const [chunk, meta] = /** @type {[EncodedVideoChunk, EncodedVideoChunkMetadata | undefined]} */ (
        this.colors.shift()
      );
      const beside = /** @type {EncodedVideoChunk} */ (this.alphas.shift());
      const alpha = new Uint8Array(beside.byteLength);
      beside.copyTo(alpha);
      this.written = this.written
        .then(() => this.write(chunk, alpha, meta))
        .catch((error) => void (this.failure ??= error));
    }
  }

  async finish() {
    await Promise.all([this.color.flush(), this.alpha.flush()]).catch((error) => (this.failure ??= error));
    await this.written;
    this.check();
    this.close();
  }

  close() {
    for (const encoder of [this.color, this.alpha]) if (encoder.state !== 'closed') encoder.close();
  }

  check() {
    if (!this.failure) return;
    const words = this.failure instanceof Error ? this.failure.message : String(this.failure);
    throw new TraceCutError('unsupported', `the browser's video encoder gave up: ${words}`, { cause: this.failure });
  }
}

/**
 * @param {VideoEncoder} encoder
 * @param {VideoFrame} frame
 * @param {boolean} keyFrame
 */
function encode(encoder, frame, keyFrame) {
  try {
    encoder.encode(frame, { keyFrame });
  } finally {
    frame.close();
  }
}

/**
 * A grey picture as encoders take it: brightness, then two planes of half the size for colours.
 * @param {Uint8Array} values
 * @param {number} width
 * @param {number} height
 */
function brightness(values, width, height) {
  const planes = new Uint8Array(values.length + 2 * Math.ceil(width / 2) * Math.ceil(height / 2)).fill(128);
  planes.set(values);
  return planes;
}
