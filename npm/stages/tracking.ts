// Trajectories of a clip's points and nothing else, tracked here or read from `tracks.dat`, the track file of the Moseg benchmark.

import { checkSides, illegal, isPlainObject, TraceCutError, wholeNumber } from '../check/errors.js';
import { type SessionOptions, splitOptions } from '../check/options.js';
import { atSize } from '../video/pixels.js';
import { asOptions, nothingTaken, splitTake, taken } from '../video/reader.js';
import { type VideoSource, openReader } from '../video/source.js';
import { untilAborted } from '../worker/pause.js';
import { decoderLoader, openEngine } from '../worker/remote.js';
import type { Engine, Progress } from '../session/engine.js';
import type { TrajectoryList } from '../session/result.js';
import type { Reader, Take, TakeOptions } from '../video/reader.js';

/** What is told of tracking. */
export interface TrackingProgress {
  /** Hears of the stages `flow` and `trajectories`. */
  onProgress?: (progress: Progress) => void;
}

/**
 * Options of `trajectories`: what to take of the source, and the options of a session, of which flow and tracking are
 * used.
 */
export type TrajectoryOptions = TakeOptions & SessionOptions & TrackingProgress;

/**
 * Trajectories with the clip that they are of: what `setTrajectories` and `tracksDat` take. `width` and `height` are
 * those of the frames in pixels; `times` those of the frames in seconds.
 */
export type TrackedClip = TrajectoryList & { numFrames: number; width: number; height: number; times: Float64Array };

/**
 * Follows points through a clip, and no more: flow and tracking of a session, in the time that these take. Memory grows
 * with the clip, as all of it is one window.
 *
 * ```js
 * const { count, startFrame, offset, x, y } = await trajectories(frames, { trajectory: { gridStep: 6 } });
 * ```
 */
export async function trajectories(source: VideoSource, options?: TrajectoryOptions): Promise<TrackedClip> {
  const { take, onProgress, engine: split } = checked(options);
  take.signal?.throwIfAborted();
  const reader = await openReader(source, take, decoderLoader(split.decoder));
  const engine = await openEngine(split).catch((error) => {
    reader.close();
    throw error;
  });
  try {
    const { info, times } = await pushed(engine, reader, take);
    const signal = take.signal ?? new AbortController().signal;
    const list = await untilAborted(engine.track(onProgress, signal), take.signal);
    if (!list) throw new TraceCutError('closed', 'the tracking was ended');
    return { ...list, numFrames: info.numFrames, width: info.width, height: info.height, times };
  } finally {
    reader.close();
    engine.close();
  }
}

function checked(options: unknown) {
  const { take, others } = splitTake(asOptions(options));
  const { onProgress = () => {}, ...session } = others;
  if (typeof onProgress !== 'function') throw illegal('param', 'onProgress', onProgress, 'a function');
  const split = splitOptions(session);
  const clip = isPlainObject(split.parameters.clip) ? split.parameters.clip : {};
  // Without masks nobody needs the denser trajectories that they are made from.
  const engine = { ...split, parameters: { ...split.parameters, clip: { ...clip, dense: false } } };
  return { take, onProgress: onProgress as NonNullable<TrajectoryOptions['onProgress']>, engine };
}

/** Gives all frames to the engine. */
async function pushed(engine: Engine, reader: Reader, take: Take) {
  const times = [];
  let info;
  for await (const { raw, time } of taken(reader, take)) {
    info = await engine.request('push', await atSize(raw, take.size));
    times.push(time);
  }
  if (!info) throw await nothingTaken(take, reader);
  return { info, times: Float64Array.from(times) };
}

/** The trajectories of a track file, as `setTrajectories` takes them, each with its label. */
export type TrackFile = {
  numFrames: number;
  width: number;
  height: number;
  count: number;
  startFrame: Uint32Array<ArrayBuffer>;
  offset: Uint32Array<ArrayBuffer>;
  x: Float32Array<ArrayBuffer>;
  y: Float32Array<ArrayBuffer>;
  label: Uint32Array<ArrayBuffer>;
};

const MAX_FRAMES = 100000;
const MAX_COUNT = 2 ** 31;

/**
 * Reads a track file. How large the frames are is not in it.
 *
 * ```js
 * await session.setTrajectories(await fromTracksDat(text, { width: 640, height: 480 }));
 * ```
 */
export async function fromTracksDat(
  text: string,
  size: { readonly width: number; readonly height: number },
): Promise<TrackFile> {
  if (typeof text !== 'string') throw illegal('data', 'text', text, 'the text of a track file');
  if (typeof size !== 'object' || size === null) throw illegal('param', 'size', size, 'an object {width, height}');
  checkSides('frame-size', '', size);
  const { width, height } = size;
  const lines = new Lines(text);
  const numFrames = lines.next('the number of frames').whole('a number of frames', 1, MAX_FRAMES);
  const count = lines.next('the number of tracks').whole('a number of tracks', 0, MAX_COUNT);
  const read = { label: [], startFrame: [], offset: [0], x: [], y: [] };
  for (let i = 0; i < count; i += 1) readTrack(lines, numFrames, read);
  lines.end();
  return {
    numFrames,
    width,
    height,
    count,
    startFrame: Uint32Array.from(read.startFrame),
    offset: Uint32Array.from(read.offset),
    x: Float32Array.from(read.x),
    y: Float32Array.from(read.y),
    label: Uint32Array.from(read.label),
  };
}

function readTrack(
  lines: Lines,
  numFrames: number,
  {
    label,
    startFrame,
    offset,
    x,
    y,
  }: { label: number[]; startFrame: number[]; offset: number[]; x: number[]; y: number[] },
) {
  const head = lines.next("a track's label and number of points");
  label.push(head.whole('a label', 0, MAX_COUNT));
  const points = head.whole('a number of points', 1, numFrames);
  for (let k = 0; k < points; k += 1) {
    const line = lines.next('x, y and frame of a point');
    x.push(line.number('x'));
    y.push(line.number('y'));
    const frame = line.whole('a frame', 0, numFrames - 1);
    if (k === 0) startFrame.push(frame);
    const due = Number(startFrame[startFrame.length - 1]) + k;
    if (frame !== due) throw line.error(String(frame), `frame ${due}: tracks have no gaps`);
  }
  offset.push(x.length);
}

/** The lines of a text with something on them, one after the other. */
class Lines {
  #text;
  #place = 0;
  #number = 0;

  constructor(text: string) {
    this.#text = text;
  }

  next(expected: string) {
    const words = this.#words();
    if (words) return new Line(words, this.#number);
    throw new TraceCutError('data', `the track file ends after line ${this.#number} (expected ${expected})`);
  }

  /** Refuses what comes after the last track. */
  end() {
    const words = this.#words();
    if (words) throw new Line(words, this.#number).error(`"${words.join(' ').slice(0, 40)}"`, 'the end of the file');
  }

  #words() {
    while (this.#place < this.#text.length) {
      const end = this.#text.indexOf('\n', this.#place);
      const line = this.#text.slice(this.#place, end < 0 ? undefined : end).trim();
      this.#place = end < 0 ? this.#text.length : end + 1;
      this.#number += 1;
      if (line) return line.split(/\s+/);
    }
    return null;
  }
}

/** The words of a line. */
class Line {
  #words;
  #number;
  #next = 0;

  constructor(words: string[], number: number) {
    this.#words = words;
    this.#number = number;
  }

  number(expected: string) {
    const word = this.#words[this.#next++] ?? '';
    const value = Number(word);
    if (word === '' || !Number.isFinite(value)) throw this.error(`"${word}"`, `${expected}, a finite number`);
    return value;
  }

  whole(expected: string, min: number, max: number) {
    const value = this.number(expected);
    if (Number.isInteger(value) && value >= min && value <= max) return value;
    throw this.error(String(value), `${expected}, ${min}..=${max}`);
  }

  error(found: string, expected: string) {
    return new TraceCutError('data', `line ${this.#number} of the track file: ${found} (expected ${expected})`);
  }
}
