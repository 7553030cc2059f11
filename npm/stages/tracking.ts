// Trajectories of a clip without any further stage, tracked here or read from `tracks.dat`, the track file of the Moseg benchmark.

import { TraceCutError, checkSides, checkWholeNumber, illegal, isPlainObject } from '../check/errors.js';
import { type SessionOptions, splitOptions } from '../check/options.js';
import { CLIP_STAGES, ClipWork, type Progress, RunMeter } from '../session/progress.js';
import { reduceFrame } from '../video/pixels.js';
import { TAKE_NAMES, asOptions, createEmptyError, splitTake, takeFrames } from '../video/reader.js';
import { type VideoSource, openReader } from '../video/source.js';
import { untilAborted } from '../worker/pause.js';
import { createDecoderLoader, openEngine } from '../worker/remote.js';
import type { Engine, StageStep } from '../session/engine.js';
import type { TrajectoryList } from '../session/result.js';
import type { Reader, Take, TakeOptions } from '../video/reader.js';

const STAGES_AFTER_TRACKING = CLIP_STAGES.map(({ id }) => id).filter((id) => id !== 'flow' && id !== 'trajectories');

/** Progress callback of tracking. */
export interface TrackingProgress {
  /** Called for the stages `flow` and `trajectories`. */
  onProgress?: (progress: Progress) => void;
}

/** Options of `trajectories`: the part of the source to use, and options of a session, of which flow and tracking apply. */
export type TrajectoryOptions = TakeOptions & SessionOptions & TrackingProgress;

/**
 * Trajectories with the size of their clip: input of `setTrajectories` and `tracksDat`. `width` and `height` are the size
 * of the frames in pixels, `times` their times in seconds.
 */
export type TrackedClip = TrajectoryList & { numFrames: number; width: number; height: number; times: Float64Array };

/**
 * Tracks points through a clip: only the stages flow and tracking of a session, in the time that these take. Memory grows
 * with the clip, as all of it is one window.
 *
 * ```js
 * const { count, startFrame, offset, x, y } = await trajectories(frames, { trajectory: { gridStep: 6 } });
 * ```
 */
export async function trajectories(source: VideoSource, options?: TrajectoryOptions): Promise<TrackedClip> {
  const { take, onProgress, engine: split } = checkTracking(options);
  take.signal?.throwIfAborted();
  const reader = await openReader(source, take, createDecoderLoader(split.decoder));
  const engine = await openEngine(split).catch((error) => {
    reader.close();
    throw error;
  });
  try {
    const { info, times } = await pushFrames(engine, reader, take);
    const signal = take.signal ?? new AbortController().signal;
    const tracking = new RunMeter(new ClipWork(times.length, times.length, 0, false), STAGES_AFTER_TRACKING);
    const report = (step: StageStep) =>
      onProgress({ ...step, ...tracking.countStep({ ...step, window: 0 }, times.length, times.length) });
    const list = await untilAborted(engine.track(report, signal), take.signal);
    if (!list) throw new TraceCutError('closed', 'the tracking was ended');
    return { ...list, numFrames: info.numFrames, width: info.width, height: info.height, times };
  } finally {
    reader.close();
    engine.close();
  }
}

function checkTracking(options: unknown) {
  const { take, others: others } = splitTake(asOptions(options));
  const { onProgress = () => {}, ...session } = others;
  if (typeof onProgress !== 'function') throw illegal('param', 'onProgress', onProgress, 'a function');
  const split = splitOptions(session, { others: [...TAKE_NAMES, 'onProgress'] });
  const clip = isPlainObject(split.parameters.clip) ? split.parameters.clip : {};
  // The denser trajectories are needed for masks only.
  const engine = { ...split, parameters: { ...split.parameters, clip: { ...clip, dense: false } } };
  return { take, onProgress: onProgress as NonNullable<TrajectoryOptions['onProgress']>, engine };
}

/** Pushes all frames to the engine. */
async function pushFrames(engine: Engine, reader: Reader, take: Take) {
  const times = [];
  let info;
  for await (const { raw, time } of takeFrames(reader, take)) {
    info = await engine.request('push', await reduceFrame(raw, take.size));
    times.push(time);
  }
  if (!info) throw await createEmptyError(take, reader);
  return { info, times: Float64Array.from(times) };
}

/** Trajectories of a track file, as `setTrajectories` takes them, each with its label. */
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

/** Most frames of a track file. */
const MAX_FRAMES = 100000;
/** Most tracks, and highest label, of a track file. */
const MAX_COUNT = 2 ** 31;

/**
 * Parses a track file. It does not contain the size of the frames.
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
  const numFrames = lines.next('the number of frames').parseWhole('a number of frames', 1, MAX_FRAMES);
  const count = lines.next('the number of tracks').parseWhole('a number of tracks', 0, MAX_COUNT);
  const arrays = { label: [], startFrame: [], offset: [0], x: [], y: [] };
  for (let i = 0; i < count; i += 1) readTrack(lines, numFrames, arrays);
  lines.end();
  return {
    numFrames,
    width,
    height,
    count,
    startFrame: Uint32Array.from(arrays.startFrame),
    offset: Uint32Array.from(arrays.offset),
    x: Float32Array.from(arrays.x),
    y: Float32Array.from(arrays.y),
    label: Uint32Array.from(arrays.label),
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
  label.push(head.parseWhole('a label', 0, MAX_COUNT));
  const points = head.parseWhole('a number of points', 1, numFrames);
  for (let k = 0; k < points; k += 1) {
    const line = lines.next('x, y and frame of a point');
    x.push(line.parseNumber('x'));
    y.push(line.parseNumber('y'));
    const frame = line.parseWhole('a frame', 0, numFrames - 1);
    if (k === 0) startFrame.push(frame);
    const expected = Number(startFrame[startFrame.length - 1]) + k;
    if (frame !== expected) throw line.createError(String(frame), `frame ${expected}: tracks have no gaps`);
  }
  offset.push(x.length);
}

/** Reads the non-empty lines of a text in order. */
class Lines {
  #text;
  #offset = 0;
  #lineNumber = 0;

  constructor(text: string) {
    this.#text = text;
  }

  next(expected: string) {
    const fields = this.#nextFields();
    if (fields) return new Line(fields, this.#lineNumber);
    throw new TraceCutError('data', `the track file ends after line ${this.#lineNumber} (expected ${expected})`);
  }

  /** Throws if anything follows the last track. */
  end() {
    const fields = this.#nextFields();
    if (fields)
      throw new Line(fields, this.#lineNumber).createError(`"${fields.join(' ').slice(0, 40)}"`, 'the end of the file');
  }

  #nextFields() {
    while (this.#offset < this.#text.length) {
      const end = this.#text.indexOf('\n', this.#offset);
      const line = this.#text.slice(this.#offset, end < 0 ? undefined : end).trim();
      this.#offset = end < 0 ? this.#text.length : end + 1;
      this.#lineNumber += 1;
      if (line) return line.split(/\s+/);
    }
    return null;
  }
}

/** Parses the fields of a line. */
class Line {
  #fields;
  #lineNumber;
  #next = 0;

  constructor(fields: string[], lineNumber: number) {
    this.#fields = fields;
    this.#lineNumber = lineNumber;
  }

  parseNumber(expected: string) {
    const word = this.#fields[this.#next++] ?? '';
    const value = Number(word);
    if (word === '' || !Number.isFinite(value)) throw this.createError(`"${word}"`, `${expected}, a finite number`);
    return value;
  }

  parseWhole(expected: string, min: number, max: number) {
    const value = this.parseNumber(expected);
    if (Number.isInteger(value) && value >= min && value <= max) return value;
    throw this.createError(String(value), `${expected}, ${min}..=${max}`);
  }

  createError(found: string, expected: string) {
    return new TraceCutError('data', `line ${this.#lineNumber} of the track file: ${found} (expected ${expected})`);
  }
}
