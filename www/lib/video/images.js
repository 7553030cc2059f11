// Animated GIF, PNG and WebP, and still images of one frame, by the browser's image decoder.

import { TraceCutError } from '../check/errors.js';
import { readAndClose } from './pixels.js';

/**
 * The part of `ImageDecoder` that is used here; not every library of types knows it.
 * @typedef {object} Decoder
 * @property {{ready: Promise<void>, selectedTrack: {frameCount: number} | null}} tracks
 * @property {Promise<void>} completed
 * @property {(options: {frameIndex: number}) => Promise<{image: VideoFrame}>} decode
 * @property {() => void} close
 */

/** @typedef {(new (init: object) => Decoder) & {isTypeSupported: (type: string) => Promise<boolean>}} DecoderClass */

/** Microseconds of a frame of an animation that does not say how long it lasts. */
const USUAL_LENGTH = 100_000;

/**
 * @param {Blob} file
 * @param {string} type
 * @param {boolean} damaged whether its facts may be those of the frames before damage
 * @returns {Promise<import('./reader.js').Reader>}
 */
export async function openImage(file, type, damaged = false) {
  const decoder = await decoderOf(file, type, damaged);
  const count = decoder.tracks.selectedTrack?.frameCount ?? 0;
  /** @type {Promise<{times: Float64Array, end: number, width: number, height: number}> | undefined} */
  let facts;
  /** @type {TraceCutError | undefined} */
  let damage;
  const onDamage = damaged ? (/** @type {TraceCutError} */ error) => void (damage = error) : undefined;
  const measured = () => (facts ??= measure(decoder, count, onDamage));
  return {
    get damage() {
      return damage;
    },
    async info() {
      const { end, width, height, times } = await measured();
      const numFrames = times.length;
      return {
        width,
        height,
        duration: end,
        frameRate: numFrames > 1 ? numFrames / end : NaN,
        numFrames,
        codec: type,
        decodable: true,
      };
    },
    async times() {
      return (await measured()).times;
    },
    async *frames() {
      let begin = 0;
      for (let frameIndex = 0; frameIndex < count; frameIndex += 1) {
        const image = await frameAt(decoder, frameIndex);
        const length = lengthOf(image);
        yield {
          time: begin / 1e6,
          duration: length / 1e6,
          read: (size) => readAndClose(image, size),
          close: () => image.close(),
        };
        begin += length;
      }
    },
    close: () => decoder.close(),
  };
}

/**
 * @param {Blob} file
 * @param {string} type
 * @param {boolean} damaged
 * @returns {Promise<Decoder>}
 */
async function decoderOf(file, type, damaged) {
  const Kind = /** @type {{ImageDecoder?: DecoderClass}} */ (globalThis).ImageDecoder;
  if (!Kind || !(await Kind.isTypeSupported(type))) {
    throw new TraceCutError(
      'unsupported',
      `this browser cannot take ${type} apart; convert it to MP4 or WebM, or pass its frames as a list`,
    );
  }
  const decoder = new Kind({ data: await file.arrayBuffer(), type });
  try {
    await decoder.tracks.ready;
    await (damaged ? decoder.completed.catch(() => {}) : decoder.completed);
  } catch (error) {
    decoder.close();
    throw cutOff(error);
  }
  return decoder;
}

/**
 * Durations are known only of decoded frames.
 * @param {Decoder} decoder
 * @param {number} count
 * @param {((error: TraceCutError) => void) | undefined} onDamage with it, those before damage are measured
 */
async function measure(decoder, count, onDamage) {
  const times = new Float64Array(count);
  let [end, width, height] = [0, 0, 0];
  for (let frameIndex = 0; frameIndex < count; frameIndex += 1) {
    const image = await frameAt(decoder, frameIndex).catch((error) => {
      if (!onDamage || frameIndex === 0) throw error;
      onDamage(error);
      return null;
    });
    if (!image) return { times: times.slice(0, frameIndex), end: end / 1e6, width, height };
    times[frameIndex] = end / 1e6;
    end += lengthOf(image);
    if (frameIndex === 0) [width, height] = [image.displayWidth, image.displayHeight];
    image.close();
  }
  return { times, end: end / 1e6, width, height };
}

/**
 * @param {Decoder} decoder
 * @param {number} frameIndex
 */
async function frameAt(decoder, frameIndex) {
  try {
    return (await decoder.decode({ frameIndex })).image;
  } catch (error) {
    throw cutOff(error);
  }
}

/**
 * Microseconds: whole numbers, whose sums are exact.
 * @param {VideoFrame} image
 */
const lengthOf = (image) => image.duration || USUAL_LENGTH;

/** @param {unknown} cause */
const cutOff = (cause) =>
  new TraceCutError('truncated', `the image cannot be decoded: it is cut off or damaged (${String(cause)})`, { cause });
