// Reads frames from a list, and frames that are image files in a folder.

import { TraceCutError, illegal, typeTag, withFrame } from '../check/errors.js';
import { type FrameSource, type RawFrame, toRawFrame } from '../worker/frames.js';
import { compareNames } from './file-kind.js';
import type { Reader } from './reader.js';

/** A frame with its time. */
export interface FrameAtTime {
  frame: FrameSource;
  /** Time in seconds; computed from its number in the list and `frameRate` if not given. */
  time?: number;
  /** Duration in seconds, if known. */
  duration?: number;
  /** File name for errors. */
  name?: string;
  /** Clip of the frame: a frame of another clip than the one before starts over, with its own size, times, objects, shots. */
  clip?: string;
}

/** A frame of a list or a stream, with or without a time. */
export type ListedFrame = FrameSource | FrameAtTime;

export function openListed(
  list: AsyncIterable<ListedFrame> | Iterable<ListedFrame | Promise<ListedFrame>> | ReadableStream<ListedFrame>,
  {
    frameRate,
    loadDecoder,
    maxPixels,
  }: { frameRate: number; loadDecoder: () => Promise<WebAssembly.Module>; maxPixels?: number },
): Reader {
  const stream = typeTag(list) === 'ReadableStream' ? new OpenStream(list as ReadableStream<ListedFrame>) : null;
  return {
    async info() {
      throw new TraceCutError('unsupported', 'a list or stream of frames has no info before its frames are read');
    },
    async *frames() {
      let index = 0;
      let before = -Infinity;
      let begin = 0;
      let currentClip: string | undefined;
      for await (const item of stream ? stream.items() : (list as AsyncIterable<ListedFrame>)) {
        const frameIndex = index;
        const { clip, frame, time, duration, name } = closedOnError(item, () => {
          const clip = getClip(item, frameIndex);
          if (clip !== currentClip) [currentClip, begin, before] = [clip, frameIndex, -Infinity];
          const facts = withTime(item, frameIndex, frameIndex - begin, frameRate);
          checkLater(frameIndex, facts.time, before);
          return { ...facts, clip };
        });
        before = time;
        index += 1;
        yield {
          time,
          duration: duration ?? 1 / frameRate,
          isGuess: duration === undefined,
          clip,
          read: () => readFrame(toRawFrame(frame, loadDecoder, maxPixels), frameIndex, name),
          close: () => closeFrame(frame),
        };
      }
    },
    async times() {
      if (!Array.isArray(list) || list.some((item, index) => getClip(item, index) !== undefined)) return null;
      return Float64Array.from(list, (item, index) => withTime(item, index, index, frameRate).time);
    },
    close: () => stream?.cancel(),
  };
}

/** Returns what `read` returns; if that throws, the item is closed. */
function closedOnError<T>(item: unknown, read: () => T): T {
  try {
    return read();
  } catch (error) {
    closeFrame(typeof item === 'object' && item !== null && 'frame' in item ? item.frame : item);
    throw error;
  }
}

function checkLater(index: number, time: number, before: number) {
  if (time > before) return;
  const expected = `more than ${before} s, the time of the frame before`;
  throw new TraceCutError('data', `frame ${index} has time = ${time} s (expected ${expected})`);
}

/**
 * Reads a stream, through a reader, as not every browser can iterate over streams. Once it is read from, it is cancelled
 * if it is not read to its end.
 */
class OpenStream {
  #stream;
  #reader: ReadableStreamDefaultReader<ListedFrame> | undefined;

  constructor(stream: ReadableStream<ListedFrame>) {
    this.#stream = stream;
  }

  async *items(): AsyncGenerator<ListedFrame, void, unknown> {
    if (this.#stream.locked) throw illegal('data', 'source', this.#stream, 'a stream that nothing else reads');
    const reader = (this.#reader = this.#stream.getReader());
    try {
      for (;;) {
        const { done, value } = await reader.read();
        if (done) return;
        yield value;
      }
    } finally {
      this.cancel();
    }
  }

  /** Ends reading, also while a frame is awaited. A stream that has ended or failed stays as it is. */
  cancel() {
    const reader = this.#reader;
    this.#reader = undefined;
    reader?.cancel().catch(() => {});
    reader?.releaseLock();
  }
}

async function readFrame(reading: Promise<RawFrame>, index: number, name: string | undefined): Promise<RawFrame> {
  try {
    const raw = await reading;
    return raw.kind === 'file' ? { ...raw, index, name: name ?? raw.name } : raw;
  } catch (error) {
    throw withFrame(error, { index, name });
  }
}

function getClip(item: unknown, index: number): string | undefined {
  if (typeof item !== 'object' || item === null || !('frame' in item)) return undefined;
  const { clip } = item as FrameAtTime;
  if (clip !== undefined && typeof clip !== 'string') throw illegal('data', `clip of frame ${index}`, clip, 'a string');
  return clip;
}

/** @param place number of the frame in its clip */
function withTime(item: unknown, index: number, place: number, frameRate: number): FrameAtTime & { time: number } {
  const defaultTime = place / frameRate;
  if (typeof item === 'object' && item !== null && 'frame' in item) {
    const time = 'time' in item && item.time !== undefined ? item.time : defaultTime;
    if (typeof time !== 'number' || !Number.isFinite(time)) {
      throw new TraceCutError('data', `time = ${String(time)} of frame ${index} (expected a number of seconds)`);
    }
    const { frame, duration, name } = item as FrameAtTime;
    if (duration !== undefined && !(duration > 0 && duration < Infinity))
      throw new TraceCutError('data', `duration = ${String(duration)} of frame ${index} (expected seconds, above 0)`);
    return { frame, time, duration, name };
  }
  if (typeTag(item) === 'VideoFrame') return { frame: item as VideoFrame, time: (item as VideoFrame).timestamp / 1e6 };
  return { frame: item as FrameSource, time: defaultTime };
}

function closeFrame(frame: unknown) {
  if (typeTag(frame) === 'VideoFrame') (frame as VideoFrame).close();
}

/** A frame of a folder, as `segmentVideo` and `videoFrames` take it: its bytes or file, and its name. */
export interface FrameFile {
  frame: Uint8Array<ArrayBuffer> | File;
  name: string;
}

/** Names of files that are read, and of images that cannot be read. */
const FRAME_NAME = /\.(png|jpe?g)$/i;
const OTHER_IMAGE_NAME = /\.(webp|gif|bmp|tiff?|avif|heic|p[pgn]m|exr)$/i;

/**
 * Selects and sorts the names of frames in natural order (frame2 before frame10). Hidden files and files that are no image
 * are dropped.
 * @param folder its name, for errors
 */
export function sortFrameNames(names: readonly string[], folder: string): string[] {
  const visible = names.filter((name) => !name.startsWith('.'));
  const unsupported = visible.find((name) => OTHER_IMAGE_NAME.test(name));
  if (unsupported !== undefined) throw illegal('data', 'a frame', unsupported, 'the name of a PNG or JPEG file');
  const frames = visible.filter((name) => FRAME_NAME.test(name)).sort(compareNames);
  if (frames.length > 0) return frames;
  const content = visible.length > 0 ? `only ${visible.slice(0, 3).join(', ')}` : 'nothing';
  throw new TraceCutError('no-frames', `${folder} has no PNG or JPEG files; there is ${content}`);
}

/**
 * Reads the frames that are PNG or JPEG files in a folder, in the order of the numbers in their names (frame2 before
 * frame10), one at a time. Hidden files and files that are no image are dropped. In Node a folder is given by its path; a
 * page passes the files that a user chose.
 *
 * ```js
 * for await (const window of segmentVideo(readFrames('frames'), { frameRate: 30 })) console.log(window.objects);
 * ```
 * @param folder its path or `file:` address, or its files
 * @returns for `segmentVideo`; an error in decoding a frame contains its name
 * @throws TraceCutError `no-frames` if the folder has no such file, `data` if a frame is in another format
 */
export async function* readFrames(folder: string | URL | Iterable<File>): AsyncGenerator<FrameFile, void, undefined> {
  if (typeof folder === 'string' || typeTag(folder) === 'URL') {
    const hint = 'pass the files themselves, as `<input type="file" webkitdirectory>` gives them';
    throw new TraceCutError('unsupported', `a page cannot read folders by name; ${hint}`);
  }
  if (typeof folder !== 'object' || folder === null || !(Symbol.iterator in folder))
    throw illegal('data', 'folder', folder, 'the name of a folder (in Node), or a list of files');
  const byName = new Map<string, File>();
  for (const file of folder) {
    if (typeTag(file) !== 'File') throw illegal('data', 'a file of the folder', file, 'a File');
    if (byName.has(file.name)) throw illegal('data', 'a file of the folder', file.name, 'files of different names');
    byName.set(file.name, file);
  }
  for (const name of sortFrameNames([...byName.keys()], 'the list of files')) yield { frame: byName.get(name)!, name };
}
