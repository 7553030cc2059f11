// Objects cut out of their frames, or their opacity, as PNG files in an archive or as one animated PNG: encoded while the
// stream is read, so that only a few frames are in memory.

import { TraceCutError, checkChoice, checkOptions, illegal, isIterable } from '../../check/errors.js';
import { checkMasks, getEnd, getTimes, readLabels, selectLabels } from '../../check/masks.js';
import { type MaskEdges, checkEdges } from '../edit/adjust.js';
import { prefetch } from '../edit/prefetch.js';
import { checkSize, createTooFewError, readPixels, scaleMask } from '../edit/at-size.js';
import { VERSION } from '../../parameters.js';
import { Encoder } from '../../text.js';
import { Zip, ZipPassThrough } from '../../vendor/zip.js';
import { createZipDate } from '../../worker/aside-here.js';
import { runTask } from '../../worker/aside.js';
import { yieldThread } from '../../worker/pause.js';
import { concatenate, encodeFrameHead, encodeHead, encodeTail } from '../../worker/pixels.js';
import { formatPngName } from './data.js';
import { type EncodeFrames, type EncodeItem, createTiming } from './video.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';
import type { WasmSource } from '../../check/options.js';
import type { ExportProgress } from './masks.js';

/** Options of `encodeImages`. */
export interface EncodeImagesOptions {
  /** `cutout`, the objects alone on a clear background, if not given; `alpha`, their opacity, white on black. */
  style?: 'cutout' | 'alpha';
  /** `zip`, an archive of PNG files and `images.json` with their times, if not given; `apng`, one looping animated PNG. */
  format?: 'zip' | 'apng';
  /** Objects to keep; all but the background if not given. */
  objects?: ObjectChoice;
  /** Adjusts the masks: removes specks, grows or shrinks objects, softens edges. */
  edges?: MaskEdges;
  /** Frames per second, if the masks have no times; 25 if not given. */
  frameRate?: number;
  /** As for a session; needed if masks are smaller than the frames. */
  decoder?: WasmSource;
  /** Called for each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Aborts the work: reading rejects with its reason. */
  signal?: AbortSignal;
}

const LEGAL = ['style', 'format', 'objects', 'edges', 'frameRate', 'decoder', 'onProgress', 'signal'];

/** Frames per second of masks without times. */
const DEFAULT_FRAME_RATE = 25;

/** Largest archive: ZIP without its 64-bit extension addresses 4 GiB; 16 MiB are left for the directory. */
const MAX_ARCHIVE_BYTES = 2 ** 32 - 2 ** 24;

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
  checkChoice('format', format, ['zip', 'apng']);
  if (!isIterable(frames))
    throw illegal('param', 'frames', frames, 'an iterable of the frames, one for each frame of the masks');
  const times = getTimes(masks, checkedOptions.frameRate) ?? getTimes(masks, frameRate)!;
  const plan = { style, selected: selectLabels(objects), edges: checkEdges(edges), decoder };
  const clip = { masks, times, end: getEnd(masks, times, frameRate) };
  const pictures = paintFrames(masks, frames, plan, signal, onProgress);
  return createStream(format === 'zip' ? writeArchive(pictures, clip) : writeAnimation(pictures, clip), signal);
}

interface ImagePlan {
  style: 'cutout' | 'alpha';
  selected: Uint8Array;
  edges: Required<MaskEdges>;
  decoder: WasmSource | undefined;
}

type ImageClip = { masks: MaskSource; times: Float64Array; end: number };

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
  let t = 0;
  const take = async (item: EncodeItem, index: number) => {
    signal?.throwIfAborted();
    const { data, width: across, height: down } = await readPixels(item, index);
    const picture = { data: data.slice(), width: across, height: down };
    if (index === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, index);
    return {
      picture,
      mask: scaleMask({ labels: readLabels(masks, index), width, height }, picture, chosen, edges, decoder),
    };
  };
  for await (const { picture, mask } of prefetch(frames, numFrames, take)) {
    signal?.throwIfAborted();
    const { data } = picture;
    const { alpha } = mask;
    const rgba = style === 'cutout';
    const chunk = (sequence: number | undefined) => {
      const pixels = { ...size, sequence, ...(rgba ? { data, opacity: alpha } : { data: alpha }) };
      return runTask({ kind: 'pixels', level: COMPRESSION_LEVEL, pixels: { ...pixels, channels: rgba ? 4 : 1 } }, [
        alpha.buffer,
      ]);
    };
    yield { ...size, rgba, t, chunk };
    t += 1;
    onProgress?.({ done: t, total: numFrames });
  }
  signal?.throwIfAborted();
  if (t < numFrames) throw createTooFewError(t, numFrames);
}

async function* writeArchive(
  pictures: AsyncGenerator<EncodablePicture, void, undefined>,
  { masks, times, end }: ImageClip,
): AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined> {
  let chunks: Uint8Array<ArrayBuffer>[] = [];
  let total = 0;
  const zip = new Zip((error, bytes) => {
    if (error) throw error;
    chunks.push(bytes);
    total += bytes.length;
  });
  const takeChunks = () => {
    const parts = chunks;
    chunks = [];
    return parts;
  };
  const begin = (name: string) => {
    const file = new ZipPassThrough(name);
    file.mtime = createZipDate();
    zip.add(file);
    return file;
  };
  const size = { width: 0, height: 0 };
  for await (const { width, height, rgba, t, chunk } of pictures) {
    Object.assign(size, { width, height });
    const bytes = concatenate([encodeHead({ width, height, rgba }), await chunk(), encodeTail()]);
    if (total + bytes.length > MAX_ARCHIVE_BYTES)
      throw new TraceCutError(
        'unsupported',
        `the archive exceeds ${MAX_ARCHIVE_BYTES} bytes after ${t} frames; use a smaller size or fewer frames`,
      );
    const file = begin(formatPngName(t));
    for (let from = 0; from < bytes.length; from += CHUNK_BYTES) {
      file.push(bytes.subarray(from, from + CHUNK_BYTES), from + CHUNK_BYTES >= bytes.length);
      yield* takeChunks();
      await yieldThread();
    }
  }
  const { numFrames } = masks;
  const files = Array.from({ length: numFrames }, (_, t) => formatPngName(t));
  const json = { generator: 'tracecut', version: VERSION, ...size, numFrames, times: [...times], end, files };
  begin('images.json').push(new Encoder().encode(`${JSON.stringify(json, null, 2)}\n`), true);
  zip.end();
  yield* takeChunks();
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
