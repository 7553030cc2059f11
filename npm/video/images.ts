// Animated GIF, PNG, WebP and AVIF, and still images of one frame, by the browser's image decoder.

import { TraceCutError } from '../check/errors.js';
import { averageRate } from '../check/masks.js';
import { fromImage } from '../worker/frames.js';
import type { Reader } from './reader.js';

/** The part of `ImageDecoder` that is used here; not every library of types knows it. */
export interface Decoder {
  tracks: { ready: Promise<void>; selectedTrack: { frameCount: number } | null };
  completed: Promise<void>;
  decode: (options: { frameIndex: number }) => Promise<{ image: VideoFrame }>;
  close: () => void;
}

export type DecoderClass = (new (init: object) => Decoder) & { isTypeSupported: (type: string) => Promise<boolean> };

/** Microseconds of a frame of an animation that does not say how long it lasts. */
const USUAL_LENGTH = 100_000;

/** @param type by its content */
export async function openImage(file: Blob, type: string): Promise<Reader> {
  const Kind = (globalThis as { ImageDecoder?: DecoderClass }).ImageDecoder;
  if (Kind && (await Kind.isTypeSupported(type))) return animationReader(await decoderOf(Kind, file, type), type);
  if (!(await isAnimated(file, type))) return stillReader(await bitmapOf(file, type), type);
  throw new TraceCutError(
    'unsupported',
    `this browser cannot take the pictures of ${type} apart; convert it to MP4 or WebM, or pass its frames as a list`,
  );
}

async function decoderOf(Kind: DecoderClass, file: Blob, type: string) {
  const decoder = new Kind({ data: await file.arrayBuffer(), type });
  try {
    await decoder.tracks.ready;
  } catch (error) {
    decoder.close();
    throw cutOff(error);
  }
  const fault = await decoder.completed.then(() => null, cutOff);
  return { decoder, fault };
}

/** @param opened `fault` where the file ends too early */
function animationReader({ decoder, fault }: { decoder: Decoder; fault: TraceCutError | null }, type: string): Reader {
  const count = decoder.tracks.selectedTrack?.frameCount ?? 0;
  let facts: ReturnType<typeof measure> | undefined;
  const reader = {
    damage: fault ?? undefined,
    async info() {
      const { end, width, height, times } = await measured();
      return factsOf(type, { width, height, duration: end, numFrames: times.length });
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
          read: async () => ({ kind: 'image', image: image.clone() }),
          close: () => image.close(),
        };
        begin += length;
      }
      if (fault) throw fault;
    },
    close: () => decoder.close(),
  } as Reader;
  const measured = () => (facts ??= measure(decoder, count, (error) => (reader.damage ??= error)));
  return reader;
}

function stillReader(image: ImageBitmap, type: string): Reader {
  const { width, height } = image;
  const duration = USUAL_LENGTH / 1e6;
  return {
    info: async () => factsOf(type, { width, height, duration, numFrames: 1 }),
    times: async () => Float64Array.of(0),
    async *frames() {
      yield { time: 0, duration, read: () => fromImage(image), close() {} };
    },
    close: () => image.close(),
  };
}

function factsOf(codec: string, facts: { width: number; height: number; duration: number; numFrames: number }) {
  return { ...facts, frameRate: averageRate(facts.numFrames, facts.duration), codec, decodable: true };
}

async function bitmapOf(file: Blob, type: string) {
  try {
    return await createImageBitmap(file);
  } catch (cause) {
    const words = `this browser cannot decode ${type}, or the file is damaged; convert it to PNG or JPEG`;
    throw new TraceCutError('unsupported', words, { cause });
  }
}

/** Where APNG has its chunk `acTL`, extended WebP its flag, AVIF its brand. A GIF says nothing in front. */
async function isAnimated(file: Blob, type: string) {
  const bytes = new Uint8Array(await file.slice(0, 2 ** 20).arrayBuffer());
  const text = new TextDecoder('latin1').decode(bytes);
  if (type === 'image/webp') return text.startsWith('VP8X', 12) && (Number(bytes[20]) & 2) !== 0;
  if (type === 'image/png') return (text.split('IDAT')[0] ?? '').includes('acTL');
  return type === 'image/gif' || (type === 'image/avif' && text.slice(0, 48).includes('avis'));
}

/**
 * Durations are known only of decoded frames.
 * @param onDamage told where those before damage are measured
 */
async function measure(decoder: Decoder, count: number, onDamage: (error: TraceCutError) => void) {
  const times = new Float64Array(count);
  let [end, width, height] = [0, 0, 0];
  for (let frameIndex = 0; frameIndex < count; frameIndex += 1) {
    const image = await frameAt(decoder, frameIndex).catch((error) => {
      if (frameIndex === 0) throw error;
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

async function frameAt(decoder: Decoder, frameIndex: number) {
  try {
    return (await decoder.decode({ frameIndex })).image;
  } catch (error) {
    throw cutOff(error);
  }
}

/** Microseconds: whole numbers, whose sums are exact. */
const lengthOf = (image: VideoFrame) => image.duration || USUAL_LENGTH;

const cutOff = (cause: unknown) =>
  new TraceCutError('truncated', 'the image cannot be decoded: it is cut off or damaged', { cause });
