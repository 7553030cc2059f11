// A video file as it is written: the browser encodes, the vendored library puts it together.

import { TraceCutError } from '../errors.js';
import { QUANTIZER, bitrateOf } from './quality.js';
import { addSound, formatOf } from './sound-track.js';
import { AlphaEncoder } from './video-alpha.js';
import { part } from '../places.js';

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
  const media = await part(import('../vendor/media.js'));
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
