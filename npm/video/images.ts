// Animated GIF, PNG, WebP and AVIF, and still images of one frame, decoded by the browser.

import { TraceCutError } from '../check/errors.js';
import { computeFrameRate } from '../check/masks.js';
import { fromImage } from '../worker/frames.js';
import type { Reader } from './reader.js';

/** The part of `ImageDecoder` that is used here; not every type library has it. */
export interface Decoder {
  tracks: { ready: Promise<void>; selectedTrack: { frameCount: number } | null };
  completed: Promise<void>;
  decode: (options: { frameIndex: number }) => Promise<{ image: VideoFrame }>;
  close: () => void;
}

export type DecoderClass = (new (init: object) => Decoder) & { isTypeSupported: (type: string) => Promise<boolean> };

/** Duration of an animation's frame without one, in microseconds. */
const DEFAULT_DURATION_US = 100_000;

/** @param type media type of its content */
export async function openImage(file: Blob, type: string): Promise<Reader> {
  const Kind = (globalThis as { ImageDecoder?: DecoderClass }).ImageDecoder;
  if (Kind && (await Kind.isTypeSupported(type))) {
    const open = () => openDecoder(Kind, file, type);
    return createAnimationReader(await open(), open, type);
  }
  if (!(await isAnimated(file, type))) return createStillReader(await createBitmap(file, type), type);
  throw new TraceCutError(
    'unsupported',
    `this browser cannot decode animated ${type}; convert it to MP4 or WebM, or pass its frames as a list`,
  );
}

async function openDecoder(Kind: DecoderClass, file: Blob, type: string): Promise<OpenDecoder> {
  const decoder = new Kind({ data: await file.arrayBuffer(), type });
  try {
    await decoder.tracks.ready;
  } catch (error) {
    decoder.close();
    throw createCutError(error);
  }
  const fault = await decoder.completed.then(() => null, createCutError);
  return { decoder, fault };
}

/** A decoder; `fault` is set if the file ends too early. */
type OpenDecoder = { decoder: Decoder; fault: TraceCutError | null };

/** @param open opens a decoder of the same file: Firefox cannot decode a frame again that was closed */
function createAnimationReader(
  { decoder, fault }: OpenDecoder,
  open: () => Promise<OpenDecoder>,
  type: string,
): Reader {
  const count = decoder.tracks.selectedTrack?.frameCount ?? 0;
  let measuring: ReturnType<typeof measure> | undefined;
  const reader = {
    damage: fault ?? undefined,
    async info() {
      const { end, width, height, times } = await measureOnce();
      return toInfo(type, { width, height, duration: end, numFrames: times.length });
    },
    async times() {
      return (await measureOnce()).times;
    },
    async *frames() {
      const { decoder } = await open();
      try {
        let begin = 0;
        for (let frameIndex = 0; frameIndex < count; frameIndex += 1) {
          const image = await decodeFrame(decoder, frameIndex);
          const durationUs = getDurationUs(image);
          let isRead = false;
          yield {
            time: begin / 1e6,
            duration: durationUs / 1e6,
            // The caller closes the frames that it reads.
            read: async () => {
              isRead = true;
              return { kind: 'image', image };
            },
            close: () => {
              if (!isRead) image.close();
            },
          };
          begin += durationUs;
        }
      } finally {
        decoder.close();
      }
      if (fault) throw fault;
    },
    close: () => decoder.close(),
  } as Reader;
  const measureOnce = () => (measuring ??= measure(decoder, count, (error) => (reader.damage ??= error)));
  return reader;
}

function createStillReader(image: ImageBitmap, type: string): Reader {
  const { width, height } = image;
  const duration = DEFAULT_DURATION_US / 1e6;
  return {
    info: async () => toInfo(type, { width, height, duration, numFrames: 1 }),
    times: async () => Float64Array.of(0),
    async *frames() {
      yield { time: 0, duration, read: () => fromImage(image), close() {} };
    },
    close: () => image.close(),
  };
}

function toInfo(codec: string, facts: { width: number; height: number; duration: number; numFrames: number }) {
  return { ...facts, frameRate: computeFrameRate(facts.numFrames, facts.duration), codec, decodable: true };
}

async function createBitmap(file: Blob, type: string) {
  try {
    return await createImageBitmap(file);
  } catch (cause) {
    const message = `this browser cannot decode ${type}, or the file is damaged; convert it to PNG or JPEG`;
    throw new TraceCutError('unsupported', message, { cause });
  }
}

/** Returns true if APNG has a chunk `acTL`, extended WebP its flag or AVIF its brand. A GIF does not tell in advance. */
async function isAnimated(file: Blob, type: string) {
  const bytes = new Uint8Array(await file.slice(0, 2 ** 20).arrayBuffer());
  const text = new TextDecoder('latin1').decode(bytes);
  if (type === 'image/webp') return text.startsWith('VP8X', 12) && (Number(bytes[20]) & 2) !== 0;
  if (type === 'image/png') return (text.split('IDAT')[0] ?? '').includes('acTL');
  return type === 'image/gif' || (type === 'image/avif' && text.slice(0, 48).includes('avis'));
}

/**
 * Measures an animation: durations are known for decoded frames only.
 * @param onDamage called if only the frames before damage could be measured
 */
async function measure(decoder: Decoder, count: number, onDamage: (error: TraceCutError) => void) {
  const times = new Float64Array(count);
  let [end, width, height] = [0, 0, 0];
  for (let frameIndex = 0; frameIndex < count; frameIndex += 1) {
    const image = await decodeFrame(decoder, frameIndex).catch((error) => {
      if (frameIndex === 0) throw error;
      onDamage(error);
      return null;
    });
    if (!image) return { times: times.slice(0, frameIndex), end: end / 1e6, width, height };
    times[frameIndex] = end / 1e6;
    end += getDurationUs(image);
    if (frameIndex === 0) [width, height] = [image.displayWidth, image.displayHeight];
    image.close();
  }
  return { times, end: end / 1e6, width, height };
}

async function decodeFrame(decoder: Decoder, frameIndex: number) {
  try {
    return (await decoder.decode({ frameIndex })).image;
  } catch (error) {
    throw createCutError(error);
  }
}

/** Returns a frame's duration in microseconds: whole numbers, whose sums are exact. */
const getDurationUs = (image: VideoFrame) => image.duration || DEFAULT_DURATION_US;

const createCutError = (cause: unknown) =>
  new TraceCutError('truncated', 'the image cannot be decoded: it is cut off or damaged', { cause });
