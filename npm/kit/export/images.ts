// Objects cut out of their frames, or their opacity, as PNG files in an archive or as one animated PNG: encoded while the
// stream is read, so that only a few frames are in memory.

import { TraceCutError, checkChoice, checkOptions, illegal, isIterable } from '../../check/errors.js';
import { checkMasks, getEnd, getTimes, readLabels, selectLabels } from '../../check/masks.js';
import { type MaskEdges, checkEdges } from '../edit/adjust.js';
import { checkSize, createTooFewError, keepPicture, prefetch, readPixels, scaleMask } from '../edit/at-size.js';
import { VERSION } from '../../parameters.js';
import { loadPart } from '../../platform.js';
import { Encoder } from '../../text.js';
import { Zip, ZipPassThrough } from '../../vendor/zip.js';
import { createZipDate } from '../../worker/aside-here.js';
import { runTask } from '../../worker/aside.js';
import { yieldThread } from '../../worker/pause.js';
import { type PngPixels, concatenate, encodeFrameHead, encodeHead, encodeTail } from '../../worker/pixels.js';
import { formatPngName } from './data.js';
import { type SoundOptions, checkSound } from './video-options.js';
import { formatReadme, formatTimelineXml, planTimeline, toFrameRate } from './timeline.js';
import { type EncodeFrames, type EncodeItem, createTiming } from './video.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';
import type { WasmSource } from '../../check/options.js';
import type { ExportProgress } from './masks.js';

/** Options of `encodeImages`. */
export interface EncodeImagesOptions {
  /** `cutout`, the objects alone on a clear background, if not given; `alpha`, their opacity, white on black. */
  style?: 'cutout' | 'alpha';
  /**
   * `zip`, an archive of PNG files and `images.json` with their times, if not given; `apng`, one looping animated PNG;
   * `editor`, an archive for video editors: numbered PNG files at a constant frame rate, so that some may be repeated or
   * left out, the sound as `sound.wav`, `timeline.xml` (Final Cut Pro 7 XML), and `README.txt`.
   */
  format?: 'zip' | 'apng' | 'editor';
  /** Objects to keep; all but the background if not given. */
  objects?: ObjectChoice;
  /** Adjusts the masks: removes specks, grows or shrinks objects, softens edges. */
  edges?: MaskEdges;
  /** Frames per second, if the masks have no times; 25 if not given. */
  frameRate?: number;
  /** Sound of the format `editor`, to the end of the last frame: its own `end` is ignored; none if not given. */
  sound?: SoundOptions;
  /** As for a session; needed if masks are smaller than the frames. */
  decoder?: WasmSource;
  /** Called for each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Aborts the work: reading rejects with its reason. */
  signal?: AbortSignal;
}

const LEGAL = ['style', 'format', 'objects', 'edges', 'frameRate', 'sound', 'decoder', 'onProgress', 'signal'];

/** Frames per second of masks without times. */
const DEFAULT_FRAME_RATE = 25;

/** Largest archive: ZIP without its 64-bit extension addresses 4 GiB; 16 MiB are left for the directory. */
const MAX_ARCHIVE_BYTES = 2 ** 32 - 2 ** 24;

const SOUND_FILE = 'sound.wav';

/** Bytes added to an archive between two pauses for the page's thread, as its checksum takes time. */
const CHUNK_BYTES = 2 ** 22;

/** Compression level, 0 to 9: the next one makes files 2 % smaller and takes twice as long. */
const COMPRESSION_LEVEL = 3;

/**
 * Encodes objects cut out of their frames as PNG files with alpha, in an archive or as one animated PNG, or their opacity
 * as grey ones. Frames are encoded only while the stream is read, with a few in memory. The pictures have the frames'
 * size; smaller masks are enlarged (`enlargeMask`).
 *
 * ```js
 * const stream = await encodeImages(result, frames, { format: 'zip' });
 * const file = await new Response(stream).blob();
 * ```
 * @param frames one for each frame of the masks, in order
 * @returns the bytes of the file
 */
export async function encodeImages(
  masks: MaskSource,
  frames: EncodeFrames,
  options?: EncodeImagesOptions,
): Promise<ReadableStream<Uint8Array<ArrayBuffer>>> {
  checkMasks(masks);
  const checkedOptions = checkOptions(options ?? {}, LEGAL);
  const {
    style = 'cutout',
    format = 'zip',
    frameRate = DEFAULT_FRAME_RATE,
    objects,
    edges,
    decoder,
    signal,
    onProgress,
  } = checkedOptions;
  checkChoice('style', style, ['cutout', 'alpha']);
  checkChoice('format', format, ['zip', 'apng', 'editor']);
  if (!isIterable(frames))
    throw illegal('param', 'frames', frames, 'an iterable of the frames, one for each frame of the masks');
  const times = getTimes(masks, checkedOptions.frameRate) ?? getTimes(masks, frameRate)!;
  const plan = { style, selected: selectLabels(objects), edges: checkEdges(edges), decoder };
  const sound = checkSound(checkedOptions.sound);
  const clip = { masks, times, end: getEnd(masks, times, frameRate), folder: style, sound };
  const pictures = paintFrames(masks, frames, plan, signal, onProgress);
  const write = { zip: writeArchive, apng: writeAnimation, editor: writeEditorArchive }[format];
  return createStream(write(pictures, clip), signal);
}

interface ImagePlan {
  style: 'cutout' | 'alpha';
  selected: Uint8Array;
  edges: Required<MaskEdges>;
  decoder: WasmSource | undefined;
}

type ImageClip = {
  masks: MaskSource;
  times: Float64Array;
  end: number;
  folder: string;
  sound: Required<SoundOptions> | null;
};

/** A picture of the file; `chunk` encodes its pixels. */
type EncodablePicture = {
  width: number;
  height: number;
  rgba: boolean;
  t: number;
  chunk: (sequence?: number) => Promise<Uint8Array<ArrayBuffer>>;
};

async function* paintFrames(
  masks: MaskSource,
  frames: EncodeFrames,
  { style: style, selected: chosen, edges, decoder }: ImagePlan,
  signal: AbortSignal | undefined,
  onProgress: EncodeImagesOptions['onProgress'],
): AsyncGenerator<EncodablePicture, void, undefined> {
  const { width, height, numFrames } = masks;
  const size = { width: 0, height: 0 };
  const rgba = style === 'cutout';
  let t = 0;
  const take = async (item: EncodeItem, index: number) => {
    signal?.throwIfAborted();
    const { picture, close } = await keepPicture(item, index);
    if (index === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, index);
    const { source } = picture;
    // Pixels may be the caller's, for the next frame.
    const kept = 'data' in source ? { ...size, data: source.data.slice() } : source;
    const mask = { labels: readLabels(masks, index), width, height };
    const readsPicture = rgba && !('data' in source);
    return { picture: kept, mask: scaleMask(mask, kept, chosen, edges, decoder, readsPicture), close };
  };
  for await (const { picture, mask } of prefetch(frames, numFrames, take)) {
    signal?.throwIfAborted();
    const { alpha } = mask;
    const data = rgba ? (mask.picture ?? (await readPixels(picture, t)).data) : alpha;
    const chunk = (sequence: number | undefined) => {
      const shared = { ...size, sequence, data };
      const pixels: PngPixels = rgba ? { ...shared, opacity: alpha, channels: 4 } : { ...shared, channels: 1 };
      return runTask({ kind: 'pixels', level: COMPRESSION_LEVEL, pixels }, [
        ...new Set([data.buffer as ArrayBuffer, alpha.buffer]),
      ]);
    };
    yield { ...size, rgba, t, chunk };
    t += 1;
    onProgress?.({ done: t, total: numFrames });
  }
  signal?.throwIfAborted();
  if (t < numFrames) throw createTooFewError(t, numFrames);
}

/** A ZIP archive that is written while it is read. */
class Archive {
  #chunks: Uint8Array<ArrayBuffer>[] = [];
  #total = 0;
  #zip = new Zip((error, bytes) => {
    if (error) throw error;
    this.#chunks.push(bytes);
    this.#total += bytes.length;
  });

  /** Throws if a file of that many bytes is too much. */
  check(size: number) {
    if (this.#total + size > MAX_ARCHIVE_BYTES)
      throw new TraceCutError(
        'unsupported',
        `the archive exceeds ${MAX_ARCHIVE_BYTES} bytes; use a smaller size or fewer frames`,
      );
  }

  /** Adds a file; yields the bytes that are ready. */
  async *add(name: string, bytes: Uint8Array<ArrayBuffer>) {
    this.check(bytes.length);
    yield* this.addPieces(name, cutChunks(bytes));
  }

  async *addPieces(name: string, pieces: Iterable<Uint8Array> | AsyncIterable<Uint8Array>) {
    const file = new ZipPassThrough(name);
    file.mtime = createZipDate();
    this.#zip.add(file);
    for await (const piece of pieces) {
      file.push(piece);
      yield* this.#take();
      await yieldThread();
    }
    file.push(new Uint8Array(0), true);
    yield* this.#take();
  }

  end() {
    this.#zip.end();
    return this.#take();
  }

  #take() {
    const chunks = this.#chunks;
    this.#chunks = [];
    return chunks;
  }
}

function* cutChunks(bytes: Uint8Array) {
  for (let from = 0; from < bytes.length; from += CHUNK_BYTES) yield bytes.subarray(from, from + CHUNK_BYTES);
}

async function encodePicture({ width, height, rgba, chunk }: EncodablePicture) {
  return concatenate([encodeHead({ width, height, rgba }), await chunk(), encodeTail()]);
}

async function* writeArchive(
  pictures: AsyncGenerator<EncodablePicture, void, undefined>,
  { masks, times, end }: ImageClip,
): AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined> {
  const archive = new Archive();
  const size = { width: 0, height: 0 };
  for await (const picture of pictures) {
    Object.assign(size, { width: picture.width, height: picture.height });
    yield* archive.add(formatPngName(picture.t), await encodePicture(picture));
  }
  const { numFrames } = masks;
  const files = Array.from({ length: numFrames }, (_, t) => formatPngName(t));
  const json = { generator: 'tracecut', version: VERSION, ...size, numFrames, times: [...times], end, files };
  yield* archive.add('images.json', new Encoder().encode(`${JSON.stringify(json, null, 2)}\n`));
  yield* archive.end();
}

async function* writeEditorArchive(
  pictures: AsyncGenerator<EncodablePicture, void, undefined>,
  { times, end, folder, sound }: ImageClip,
): AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined> {
  const timeline = planTimeline(times, end);
  const seconds = timeline.length / toFrameRate(timeline.rate);
  const wav = sound && (await (await loadPart(import('./wav.js'))).openWav(sound, seconds));
  try {
    const archive = new Archive();
    const size = { width: 0, height: 0 };
    const alpha = folder === 'cutout' ? ('straight' as const) : ('none' as const);
    const formatName = (index: number) => `${folder}/${String(index + 1).padStart(6, '0')}.png`;
    let index = 0;
    for await (const picture of pictures) {
      Object.assign(size, { width: picture.width, height: picture.height });
      const last = index + Number(timeline.repeats[picture.t]);
      // A frame that is left out is not encoded.
      const bytes = index < last ? await encodePicture(picture) : null;
      for (; bytes && index < last; index += 1) yield* archive.add(formatName(index), bytes);
    }
    if (wav) {
      archive.check(wav.size);
      yield* archive.addPieces(SOUND_FILE, wav.read());
    }
    const files = { ...size, image: formatName(0), alpha, sound: wav && { file: SOUND_FILE, ...wav } };
    yield* archive.add('timeline.xml', new Encoder().encode(formatTimelineXml(timeline, files)));
    yield* archive.add('README.txt', new Encoder().encode(formatReadme(timeline, files)));
    yield* archive.end();
  } finally {
    wav?.close();
  }
}

async function* writeAnimation(
  pictures: AsyncGenerator<EncodablePicture, void, undefined>,
  { masks, times, end }: ImageClip,
): AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined> {
  const { numFrames } = masks;
  const getTiming = createTiming(times, end);
  for await (const { width, height, rgba, t, chunk } of pictures) {
    if (t === 0) yield encodeHead({ width, height, rgba, numFrames });
    // The first frame has the file's pixels, so only its header counts.
    yield encodeFrameHead({ width, height }, t === 0 ? 0 : 2 * t - 1, getTiming(t).duration);
    yield await chunk(t === 0 ? undefined : 2 * t);
  }
  yield encodeTail();
}

/** Creates a stream that encodes nothing before it is read. */
function createStream(
  pieces: AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined>,
  signal: AbortSignal | undefined,
): ReadableStream<Uint8Array<ArrayBuffer>> {
  return new ReadableStream(
    {
      async pull(controller) {
        signal?.throwIfAborted();
        const { value, done } = await pieces.next();
        if (done) controller.close();
        else controller.enqueue(value);
      },
      async cancel() {
        await pieces.return();
      },
    },
    { highWaterMark: 0 },
  );
}
