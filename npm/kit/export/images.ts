// Objects cut out of their frames, or their opacity, as PNG files in an archive or as one animated PNG: written while
// they are read, so that only a few frames are in memory.

import { TraceCutError, checkedOptions, illegal, isIterable, oneOf } from '../../check/errors.js';
import { checkMasks, chosenLabels, endOf, labelsOf, timesOf } from '../../check/masks.js';
import { type MaskEdges, checkedEdges } from '../edit/adjust.js';
import { ahead } from '../edit/ahead.js';
import { checkSize, maskAtSize, pixelsOf, tooFew } from '../edit/at-size.js';
import { VERSION } from '../../parameters.js';
import { Encoder } from '../../text.js';
import { Zip, ZipPassThrough } from '../../vendor/zip.js';
import { zipDate } from '../../worker/aside-here.js';
import { aside } from '../../worker/aside.js';
import { breath } from '../../worker/pause.js';
import { frameHead, joined, pngHead, pngTail } from '../../worker/pixels.js';
import { pngName } from './data.js';
import { type EncodeFrames, type EncodeItem, timing } from './video.js';
import type { MaskSource, ObjectChoice } from '../../check/masks.js';
import type { WasmSource } from '../../check/options.js';
import type { ExportProgress } from './masks.js';

export interface EncodeImagesOptions {
  /** `cutout`, the objects alone on nothing, if not given; `alpha`, how opaque they are, white on black. */
  style?: 'cutout' | 'alpha';
  /**
   * `zip`, an archive of PNG files and `images.json` with their times, if not given; `apng`, one animated PNG, which
   * repeats.
   */
  format?: 'zip' | 'apng';
  /** All but the background if not given. */
  objects?: ObjectChoice;
  /** Of the masks: specks left out, objects grown or shrunk, soft edges. */
  edges?: MaskEdges;
  /** Frames per second, where the masks have no times; 25 if not given. */
  frameRate?: number;
  /** As for a session, where masks are smaller than the frames. */
  decoder?: WasmSource;
  /** Told of each frame. */
  onProgress?: (progress: ExportProgress) => void;
  /** Ends the work: reading rejects with its reason. */
  signal?: AbortSignal;
}

const LEGAL = ['style', 'format', 'objects', 'edges', 'frameRate', 'decoder', 'onProgress', 'signal'];

const FRAME_RATE = 25;

/** Archives cannot say where anything lies beyond this, in bytes. */
const MOST_BYTES = 2 ** 32 - 2 ** 24;

/** An archive's checksum is counted in pieces of this size, in bytes, between which others may do something. */
const PIECE = 2 ** 22;

/** How hard to try: the next step makes files 2 % smaller and takes twice as long. */
const LEVEL = 3;

/**
 * Objects cut out of their frames as PNG files with alpha, in an archive or as one animated PNG, or their opacity as grey
 * ones: written while the stream is read and no sooner, a few frames in memory. The pictures have the frames' size;
 * masks that are smaller are enlarged by the frames (`enlargeMask`).
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
  const checked = checkedOptions(options ?? {}, LEGAL);
  const {
    style = 'cutout',
    format = 'zip',
    frameRate = FRAME_RATE,
    objects,
    edges,
    decoder,
    signal,
    onProgress,
  } = checked;
  oneOf('style', style, ['cutout', 'alpha']);
  oneOf('format', format, ['zip', 'apng']);
  if (!isIterable(frames))
    throw illegal('param', 'frames', frames, 'an iterable of the frames, one for each frame of the masks');
  const times = timesOf(masks, checked.frameRate) ?? timesOf(masks, frameRate)!;
  const plan = { style, chosen: chosenLabels(objects), edges: checkedEdges(edges), decoder };
  const clip = { masks, times, end: endOf(masks, times, frameRate) };
  const pictures = paint(masks, frames, plan, signal, onProgress);
  return streamOf(format === 'zip' ? archive(pictures, clip) : animation(pictures, clip), signal);
}

export interface Plan {
  style: 'cutout' | 'alpha';
  chosen: Uint8Array;
  edges: Required<MaskEdges>;
  decoder: WasmSource | undefined;
}

export type ImageClip = { masks: MaskSource; times: Float64Array; end: number };

/** A picture: `chunk` makes that which holds its pixels. */
export type Painted = {
  width: number;
  height: number;
  rgba: boolean;
  t: number;
  chunk: (sequence?: number) => Promise<Uint8Array<ArrayBuffer>>;
};

async function* paint(
  masks: MaskSource,
  frames: EncodeFrames,
  { style, chosen, edges, decoder }: Plan,
  signal: AbortSignal | undefined,
  onProgress: EncodeImagesOptions['onProgress'],
): AsyncGenerator<Painted, void, undefined> {
  const { width, height, numFrames } = masks;
  const size = { width: 0, height: 0 };
  let t = 0;
  const take = async (item: EncodeItem, at: number) => {
    signal?.throwIfAborted();
    const { data, width: across, height: down } = await pixelsOf(item, at);
    const picture = { data: data.slice(), width: across, height: down };
    if (at === 0) Object.assign(size, { width: picture.width, height: picture.height });
    checkSize(picture, size, at);
    return {
      picture,
      mask: maskAtSize({ labels: labelsOf(masks, at), width, height }, picture, chosen, edges, decoder),
    };
  };
  for await (const { picture, mask } of ahead(frames, numFrames, take)) {
    signal?.throwIfAborted();
    const { data } = picture;
    const { alpha } = mask;
    const rgba = style === 'cutout';
    const chunk = (sequence: number | undefined) => {
      const pixels = { ...size, sequence, ...(rgba ? { data, opacity: alpha } : { data: alpha }) };
      return aside({ kind: 'pixels', level: LEVEL, pixels: { ...pixels, channels: rgba ? 4 : 1 } }, [alpha.buffer]);
    };
    yield { ...size, rgba, t, chunk };
    t += 1;
    onProgress?.({ done: t, total: numFrames });
  }
  signal?.throwIfAborted();
  if (t < numFrames) throw tooFew(t, numFrames);
}

async function* archive(
  pictures: AsyncGenerator<Painted, void, undefined>,
  { masks, times, end }: ImageClip,
): AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined> {
  let ready: Uint8Array<ArrayBuffer>[] = [];
  let total = 0;
  const zip = new Zip((error, bytes) => {
    if (error) throw error;
    ready.push(bytes);
    total += bytes.length;
  });
  const taken = () => {
    const parts = ready;
    ready = [];
    return parts;
  };
  const begin = (name: string) => {
    const file = new ZipPassThrough(name);
    file.mtime = zipDate();
    zip.add(file);
    return file;
  };
  const about = { width: 0, height: 0 };
  for await (const { width, height, rgba, t, chunk } of pictures) {
    Object.assign(about, { width, height });
    const bytes = joined([pngHead({ width, height, rgba }), await chunk(), pngTail()]);
    if (total + bytes.length > MOST_BYTES)
      throw new TraceCutError(
        'unsupported',
        `the archive would be of more than ${MOST_BYTES} bytes after ${t} frames; take a smaller size or fewer frames`,
      );
    const file = begin(pngName(t));
    for (let from = 0; from < bytes.length; from += PIECE) {
      file.push(bytes.subarray(from, from + PIECE), from + PIECE >= bytes.length);
      yield* taken();
      await breath();
    }
  }
  const { numFrames } = masks;
  const files = Array.from({ length: numFrames }, (_, t) => pngName(t));
  const json = { generator: 'tracecut', version: VERSION, ...about, numFrames, times: [...times], end, files };
  begin('images.json').push(new Encoder().encode(`${JSON.stringify(json, null, 2)}\n`), true);
  zip.end();
  yield* taken();
}

async function* animation(
  pictures: AsyncGenerator<Painted, void, undefined>,
  { masks, times, end }: ImageClip,
): AsyncGenerator<Uint8Array<ArrayBuffer>, void, undefined> {
  const { numFrames } = masks;
  const shown = timing(times, end);
  for await (const { width, height, rgba, t, chunk } of pictures) {
    if (t === 0) yield pngHead({ width, height, rgba, numFrames });
    // Of the first frame the head alone is counted: its pixels are those of the file.
    yield frameHead({ width, height }, t === 0 ? 0 : 2 * t - 1, shown(t).duration);
    yield await chunk(t === 0 ? undefined : 2 * t);
  }
  yield pngTail();
}

/** Nothing is made before it is read. */
function streamOf(
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
