// A video file as it is written: frames, the sound of the source, and a layer of opacity for WebM.

import { TraceCutError, typeTag } from '../../check/errors.js';
import { part } from '../../places.js';
import { QUANTIZER, bitrateOf } from './quality.js';

/** @typedef {import('./quality.js').Codec} Codec */

/**
 * What a file may hold, best first: what browsers play, then what is small. @type {Record<'webm' | 'mp4' | 'alpha',
 * Codec[]>}
 */
const CODECS = { webm: ['vp9', 'vp8', 'av1'], mp4: ['avc', 'vp9', 'av1'], alpha: ['vp9', 'vp8'] };

const NAME = { webm: 'WebM', mp4: 'MP4' };

/**
 * A file that is being written; times are in seconds. @typedef {{add: (time: number, duration: number) =>
 * Promise<void>, finish: () => Promise<Blob>, cancel: () => Promise<void>}} VideoFile
 */

/**
 * @param {import('./video-painter.js').Painter} painter that has painted the first frame
 * @param {import('./video.js').Plan} plan
 * @returns {Promise<VideoFile>}
 */
export async function openFile(painter, plan) {
  const media = await part(import('../../vendor/media.js'));
  // A page in WebKitGTK dies where an encoder is the first to wake its media library; players wake it well.
  globalThis.document?.createElement('video').canPlayType('video/webm');
  const { width, height } = painter.canvas;
  const video = { width, height, frameRate: plan.frameRate };
  const codecs = plan.alpha ? CODECS.alpha : CODECS[plan.format];
  const codec = /** @type {Codec | null} */ (
    await media.getFirstEncodableVideoCodec(codecs, {
      width,
      height,
      quality: new media.Quality({ bitrate: bitrateOf(plan.quality, 'avc', video) }),
    })
  );
  if (!codec) throw noEncoder(plan, width, height, codecs);
  const bitrate = bitrateOf(plan.quality, codec, video);
  const quantizer = QUANTIZER[plan.quality][codec];
  const quality = new media.Quality(quantizer === undefined ? { bitrate } : { bitrate, quantizer });
  const target = new media.BufferTarget();
  const output = new media.Output({ format: formatOf(media, plan.format), target });
  const encoder = plan.alpha
    ? withAlpha(media, output, painter, codec, bitrate)
    : opaque(media, output, painter, codec, quality);
  const sound = plan.sound && (await addSound(media, output, plan.sound, plan.format));
  await output.start();
  return {
    async add(time, duration) {
      await encoder.add(time, duration);
      await sound?.write(time + duration);
    },
    async finish() {
      await encoder.finish();
      await sound?.write(Infinity);
      sound?.close();
      await output.finalize();
      return new Blob([/** @type {ArrayBuffer} */ (target.buffer)], { type: `video/${plan.format}` });
    },
    async cancel() {
      encoder.close();
      sound?.close();
      await output.cancel();
    },
  };
}

/**
 * @param {typeof import('../../vendor/media.js')} media
 * @param {import('../../vendor/media.js').Output} output
 * @param {import('./video-painter.js').Painter} painter
 * @param {Codec} codec
 * @param {import('../../vendor/media.js').Quality} quality
 */
function opaque(media, output, painter, codec, quality) {
  const source = new media.CanvasSource(painter.canvas, { codec, quality });
  output.addVideoTrack(source);
  const add = (/** @type {number} */ time, /** @type {number} */ duration) => source.add(time, duration);
  return { add, finish: async () => {}, close: () => {} };
}

/**
 * @param {typeof import('../../vendor/media.js')} media
 * @param {import('../../vendor/media.js').Output} output
 * @param {import('./video-painter.js').Painter} painter
 * @param {Codec} codec one of those that can be transparent
 * @param {number} bitrate
 */
function withAlpha(media, output, painter, codec, bitrate) {
  const track = new media.EncodedVideoPacketSource(codec);
  output.addVideoTrack(track);
  const encoder = new AlphaEncoder(painter, { codec: codec === 'vp8' ? 'vp8' : 'vp9', bitrate }, (color, alpha, meta) =>
    track.add(media.EncodedPacket.fromEncodedChunk(color, { alpha }), meta),
  );
  const add = (/** @type {number} */ time, /** @type {number} */ duration) => encoder.add(time, duration);
  return { add, finish: () => encoder.finish(), close: () => encoder.close() };
}

/**
 * @param {import('./video.js').Plan} plan
 * @param {number} width
 * @param {number} height
 * @param {string[]} codecs
 */
function noEncoder({ format, alpha }, width, height, codecs) {
  const other = format === 'mp4' ? "format: 'webm'" : alpha ? "a background colour and format: 'mp4'" : "format: 'mp4'";
  return new TraceCutError(
    'unsupported',
    `this browser encodes none of ${codecs.join(', ')} for ${NAME[format]} files of ${width} × ${height} pixels; try ${other}, or take PNG files from masksZip`,
  );
}

// A video that is transparent: WebM keeps the alpha of each frame as a second picture beside the first, whose
// brightness it is. Both are encoded here and not by the muxer's library, because that splits frames in a worker of its
// own making, which a strict content security policy forbids.

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
class AlphaEncoder {
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

/** @typedef {{write: (until: number) => Promise<void>, close: () => void}} SoundTrack */

/**
 * @param {typeof import('../../vendor/media.js')} media
 * @param {'webm' | 'mp4'} format
 */
export function formatOf(media, format) {
  return format === 'mp4' ? new media.Mp4OutputFormat({ fastStart: 'in-memory' }) : new media.WebMOutputFormat();
}

/**
 * Adds a track for the sound to a file that is about to be written; null where the source has none.
 * @param {typeof import('../../vendor/media.js')} media
 * @param {import('../../vendor/media.js').Output} output
 * @param {Required<import('./sound.js').SoundOptions>} sound
 * @param {'webm' | 'mp4'} format
 * @returns {Promise<SoundTrack | null>}
 */
async function addSound(media, output, { source, start, end }, format) {
  const input = opened(media, source);
  try {
    const track = (await input.canRead()) ? await input.getPrimaryAudioTrack() : null;
    const codec = await track?.getCodec();
    const decoderConfig = await track?.getDecoderConfig();
    if (!track || !codec || !decoderConfig) {
      input.dispose();
      return null;
    }
    if (!output.format.getSupportedAudioCodecs().includes(codec)) {
      const { conversionOf, converted } = await part(import('./sound-convert.js'));
      const conversion = await conversionOf(track);
      if (!conversion) throw cannotHold(codec, format);
      const target = new media.EncodedAudioPacketSource('opus');
      output.addAudioTrack(target);
      const { write, close } = converted(media, track, { conversion, target, start, end });
      return { write, close: () => (close(), input.dispose()) };
    }
    const target = new media.EncodedAudioPacketSource(codec);
    output.addAudioTrack(target);
    return copied(media, input, { packets: packetsOf(media, track, start, end), target, decoderConfig, start });
  } catch (error) {
    input.dispose();
    throw error;
  }
}

/**
 * @param {typeof import('../../vendor/media.js')} media
 * @param {import('mediabunny').Input} input
 * @param {{packets: AsyncGenerator<import('mediabunny').EncodedPacket, void, undefined>, target:
 *   import('mediabunny').EncodedAudioPacketSource, decoderConfig: AudioDecoderConfig, start: number}} parts
 * @returns {SoundTrack}
 */
function copied(media, input, { packets, target, decoderConfig, start }) {
  /** @type {import('mediabunny').EncodedPacket | null | undefined} Read, but not written yet; null after the last. */
  let next;
  let isFirst = true;
  const read = async () => (await packets.next()).value ?? null;
  return {
    async write(until) {
      if (next === undefined) next = await read();
      for (; next && next.timestamp - start < until; next = await read()) {
        const timestamp = Math.max(0, next.timestamp - start);
        await target.add(next.clone({ timestamp }), isFirst ? { decoderConfig } : undefined);
        isFirst = false;
      }
    },
    close() {
      packets.return().catch(() => {});
      input.dispose();
    },
  };
}

/**
 * Packets of which more than half lies in the stretch that is wanted: each lasts some hundredths of a second, so the
 * sound is as long as the video to within one of them. Those of plain samples may last longer and are cut.
 * @param {typeof import('../../vendor/media.js')} media
 * @param {import('mediabunny').InputAudioTrack} track
 * @param {number} start
 * @param {number} end
 */
async function* packetsOf(media, track, start, end) {
  const sink = new media.EncodedPacketSink(track);
  const first = (await sink.getPacket(start)) ?? (await sink.getFirstPacket()) ?? undefined;
  const isPlain = /^(pcm|[au]law)/.test(String(await track.getCodec()));
  const rate = await track.getSampleRate();
  for await (const whole of sink.packets(first)) {
    const packet = isPlain ? cutTo(whole, rate, start, end) : whole;
    const middle = packet.timestamp + packet.duration / 2;
    if (middle >= end) return;
    if (middle >= start) yield packet;
  }
}

/**
 * @param {import('mediabunny').EncodedPacket} packet of plain samples
 * @param {number} rate samples a second
 * @param {number} start
 * @param {number} end
 */
function cutTo(packet, rate, start, end) {
  const count = Math.round(packet.duration * rate);
  const [from, to] = [start, end].map((at) => Math.min(count, Math.max(0, Math.round((at - packet.timestamp) * rate))));
  if (from === undefined || to === undefined || from >= to || to - from === count) return packet;
  const bytes = packet.data.byteLength / count;
  const data = packet.data.subarray(from * bytes, to * bytes);
  return packet.clone({ data, timestamp: packet.timestamp + from / rate, duration: (to - from) / rate });
}

/**
 * @param {typeof import('../../vendor/media.js')} media
 * @param {Blob | ArrayBuffer | Uint8Array} source
 */
export function opened(media, source) {
  const blob =
    typeTag(source) === 'Blob' || typeTag(source) === 'File' ? source : new Blob([/** @type {any} */ (source)]);
  return new media.Input({
    source: new media.BlobSource(/** @type {Blob} */ (blob), { handleUnhandledError: () => {} }),
    formats: media.ALL_FORMATS,
  });
}

/**
 * @param {string} codec
 * @param {'webm' | 'mp4'} format
 */
function cannotHold(codec, format) {
  const [name, other] = format === 'mp4' ? ['MP4', 'webm'] : ['WebM', 'mp4'];
  return new TraceCutError(
    'unsupported',
    `sound: ${name} files cannot hold ${codec} as it is, and this browser does not turn it into Opus; try format: '${other}', or leave the sound out (soundInfo says which formats can)`,
  );
}
