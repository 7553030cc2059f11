// Frames in a list, and those that lie as image files in a folder.

import { TraceCutError, illegal, inFrame, typeTag } from '../check/errors.js';
import { type FrameSource, type RawFrame, toRawFrame } from '../worker/frames.js';
import { compareNames } from './kind.js';
import type { Reader } from './reader.js';

/** A frame with its time. */
export interface FrameAtTime {
  frame: FrameSource;
  /** Seconds; its number in the list and `frameRate` say when it is if not given. */
  time?: number;
  /** For how long it is shown, in seconds, where that is known. */
  duration?: number;
  /** For errors: the file that it is from. */
  name?: string;
  /**
   * Which clip it is of: a frame of another than the one before begins anew, with a size, times from 0, objects and
   * shots of its own.
   */
  clip?: string;
}

/** A frame of a list or a stream, with its time or without: then its number and `frameRate` say when it is. */
export type ListedFrame = FrameSource | FrameAtTime;

export function openListed(
  list: AsyncIterable<ListedFrame> | Iterable<ListedFrame | Promise<ListedFrame>> | ReadableStream<ListedFrame>,
  {
    frameRate,
    loadDecoder,
    maxPixels,
  }: { frameRate: number; loadDecoder: () => Promise<WebAssembly.Module>; maxPixels?: number },
): Reader {
  return {
    async info() {
      throw new TraceCutError(
        'unsupported',
        'a list or stream of frames has no facts before its frames are read; ask the frames themselves',
      );
    },
    async *frames() {
      let index = 0;
      let before = -Infinity;
      let begin = 0;
      let present: string | undefined;
      for await (const item of itemsOf(list)) {
        const at = index;
        const clip = clipOf(item, at);
        if (clip !== present) [present, begin, before] = [clip, at, -Infinity];
        const { frame, time, duration, name } = placed(item, at, at - begin, frameRate);
        if (!(time > before)) {
          closeFrame(frame);
          throw new TraceCutError(
            'data',
            `frame ${index} has time = ${time} s (expected more than ${before} s, the time of the frame before)`,
          );
        }
        before = time;
        index += 1;
        yield {
          time,
          duration: duration ?? 1 / frameRate,
          isGuess: duration === undefined,
          clip,
          read: () => readAs(toRawFrame(frame, loadDecoder, maxPixels), at, name),
          close: () => closeFrame(frame),
        };
      }
    },
    async times() {
      if (!Array.isArray(list) || list.some((item, index) => clipOf(item, index) !== undefined)) return null;
      return Float64Array.from(list, (item, index) => placed(item, index, index, frameRate).time);
    },
    close() {},
  };
}

/** Streams are read through a reader: not every browser lets one iterate over them. */
async function* itemsOf(
  list: AsyncIterable<ListedFrame> | Iterable<ListedFrame | Promise<ListedFrame>> | ReadableStream<ListedFrame>,
): AsyncGenerator<ListedFrame, void, unknown> {
  if (typeTag(list) !== 'ReadableStream') {
    yield* list;
    return;
  }
  const reader = (list as ReadableStream<ListedFrame>).getReader();
  let ended = false;
  try {
    for (;;) {
      const { done, value } = await reader.read();
      ended = done;
      if (done) return;
      yield value;
    }
  } finally {
    if (!ended) reader.cancel().catch(() => {});
    reader.releaseLock();
  }
}

async function readAs(reading: Promise<RawFrame>, index: number, name: string | undefined): Promise<RawFrame> {
  try {
    const raw = await reading;
    return raw.kind === 'file' ? { ...raw, index, name: name ?? raw.name } : raw;
  } catch (error) {
    throw inFrame(error, { index, name });
  }
}

function clipOf(item: unknown, index: number): string | undefined {
  if (typeof item !== 'object' || item === null || !('frame' in item)) return undefined;
  const { clip } = item as FrameAtTime;
  if (clip !== undefined && typeof clip !== 'string') throw illegal('data', `clip of frame ${index}`, clip, 'a string');
  return clip;
}

/** @param place which frame of its clip it is */
function placed(item: unknown, index: number, place: number, frameRate: number): FrameAtTime & { time: number } {
  const otherwise = place / frameRate;
  if (typeof item === 'object' && item !== null && 'frame' in item) {
    const time = 'time' in item && item.time !== undefined ? item.time : otherwise;
    if (typeof time !== 'number' || !Number.isFinite(time)) {
      throw new TraceCutError('data', `time = ${String(time)} of frame ${index} (expected a number of seconds)`);
    }
    const { frame, duration, name } = item as FrameAtTime;
    if (duration !== undefined && !(duration > 0 && duration < Infinity))
      throw new TraceCutError('data', `duration = ${String(duration)} of frame ${index} (expected seconds, above 0)`);
    return { frame, time, duration, name };
  }
  if (typeTag(item) === 'VideoFrame') return { frame: item as VideoFrame, time: (item as VideoFrame).timestamp / 1e6 };
  return { frame: item as FrameSource, time: otherwise };
}

function closeFrame(frame: unknown) {
  if (typeTag(frame) === 'VideoFrame') (frame as VideoFrame).close();
}

/** A frame of a folder, as `segmentVideo` and `videoFrames` take it: the bytes or the file, and its name. */
export interface FrameFile {
  frame: Uint8Array<ArrayBuffer> | File;
  name: string;
}

/** What is read by the name's ending, and what looks like a picture but cannot be read. */
const FRAME = /\.(png|jpe?g)$/i;
const PICTURE = /\.(webp|gif|bmp|tiff?|avif|heic|p[pgn]m|exr)$/i;

/**
 * The names of frames, in their order: numbers in them count as numbers, so that frame2 comes before frame10. Hidden
 * files and what is no picture are left out.
 * @param folder what it is called, for errors
 */
export function frameNames(names: readonly string[], folder: string): string[] {
  const seen = names.filter((name) => !name.startsWith('.'));
  const foreign = seen.find((name) => PICTURE.test(name));
  if (foreign !== undefined) throw illegal('data', 'a frame', foreign, 'the name of a PNG or JPEG file');
  const frames = seen.filter((name) => FRAME.test(name)).sort(compareNames);
  if (frames.length > 0) return frames;
  const there = seen.length > 0 ? `only ${seen.slice(0, 3).join(', ')}` : 'nothing';
  throw new TraceCutError('no-frames', `${folder} has no PNG or JPEG files; there is ${there}`);
}

/**
 * The frames that lie as PNG or JPEG files in a folder, in the order of the numbers in their names (frame2 before
 * frame10), one read at a time. Hidden files and what is no picture are left out. In Node a folder is its path; a page
 * gives the files that a user chose.
 *
 * ```js
 * for await (const window of segmentVideo(readFrames('frames'), { frameRate: 30 })) console.log(window.objects);
 * ```
 * @param folder its path or `file:` address, or its files
 * @returns for `segmentVideo`; errors of one that cannot be decoded say its name
 * @throws TraceCutError `no-frames` where the folder has no such file, `data` where a frame is in another format
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
  for (const name of frameNames([...byName.keys()], 'the list of files')) yield { frame: byName.get(name)!, name };
}
