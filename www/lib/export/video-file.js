// A video file as it is written: the browser encodes, the vendored library puts it together.

import { TraceCutError } from '../errors.js';
import { AlphaEncoder } from './video-alpha.js';

/** @typedef {'vp9' | 'vp8' | 'av1' | 'avc'} Codec */

/**
 * What a file may hold, best first: what browsers play, then what is small. @type {Record<'webm' | 'mp4' | 'alpha',
 * Codec[]>}
 */
const CODECS = { webm: ['vp9', 'vp8', 'av1'], mp4: ['avc', 'vp9', 'av1'], alpha: ['vp9', 'vp8'] };

/**
 * For each quality how coarsely each codec may round, on its own scale, and the bits a second for a pixel where the
 * encoder wants to know that instead.
 * @type {Record<'low' | 'medium' | 'high' | 'very-high', {bitsPerPixel: number} & Partial<Record<Codec, number>>>}
 */
const QUALITY = {
  low: { bitsPerPixel: 1.5, avc: 34, vp9: 44, av1: 176 },
  medium: { bitsPerPixel: 3, avc: 28, vp9: 36, av1: 144 },
  high: { bitsPerPixel: 6, avc: 22, vp9: 28, av1: 112 },
  'very-high': { bitsPerPixel: 12, avc: 16, vp9: 20, av1: 80 },
};

const NAME = { webm: 'WebM', mp4: 'MP4' };

/** Small pictures need more for each of their pixels. */
const LEAST_BITRATE = 500_000;

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
  const media = await import('../vendor/media.js');
  const { width, height } = painter.canvas;
  const bitrate = Math.max(LEAST_BITRATE, Math.round(QUALITY[plan.quality].bitsPerPixel * width * height));
  const codecs = plan.alpha ? CODECS.alpha : CODECS[plan.format];
  const codec = /** @type {Codec | null} */ (
    await media.getFirstEncodableVideoCodec(codecs, { width, height, quality: new media.Quality({ bitrate }) })
  );
  if (!codec) throw noEncoder(plan, width, height, codecs);
  const quantizer = QUALITY[plan.quality][codec];
  const quality = new media.Quality(quantizer === undefined ? { bitrate } : { bitrate, quantizer });
  const target = new media.BufferTarget();
  const format =
    plan.format === 'mp4' ? new media.Mp4OutputFormat({ fastStart: 'in-memory' }) : new media.WebMOutputFormat();
  const output = new media.Output({ format, target });
  const encoder = plan.alpha
    ? withAlpha(media, output, painter, codec, bitrate)
    : opaque(media, output, painter, codec, quality);
  await output.start();
  return {
    add: encoder.add,
    async finish() {
      await encoder.finish();
      await output.finalize();
      return new Blob([/** @type {ArrayBuffer} */ (target.buffer)], { type: `video/${plan.format}` });
    },
    async cancel() {
      encoder.close();
      await output.cancel();
    },
  };
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('../vendor/media.js').Output} output
 * @param {import('./video-painter.js').Painter} painter
 * @param {Codec} codec
 * @param {import('../vendor/media.js').Quality} quality
 */
function opaque(media, output, painter, codec, quality) {
  const source = new media.CanvasSource(painter.canvas, { codec, quality });
  output.addVideoTrack(source);
  const add = (/** @type {number} */ time, /** @type {number} */ duration) => source.add(time, duration);
  return { add, finish: async () => {}, close: () => {} };
}

/**
 * @param {typeof import('../vendor/media.js')} media
 * @param {import('../vendor/media.js').Output} output
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
