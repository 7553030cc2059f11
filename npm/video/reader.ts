// What every source of frames looks like from inside, and what is taken of it.

import { MAX_SIDE, TraceCutError, illegal, isPlainObject, wholeNumber } from '../check/errors.js';
import { WINDOWS } from '../parameters.js';
import { untilAborted } from '../worker/pause.js';
import { type ReadFrame, pixelsFrom } from './pixels.js';
import type { WasmSource } from '../check/options.js';
import type { RawFrame } from '../worker/frames.js';

/** Facts of a video. */
export interface VideoInfo {
  /** Of the frames as they are shown, in pixels. */
  width: number;
  height: number;
  /** Seconds from the begin of the first frame to the end of the last; `Infinity` for a stream. */
  duration: number;
  /** Frames per second on average, `numFrames / duration`; `NaN` where nothing says. */
  frameRate: number;
  /** Number of frames, where that can be known without decoding. */
  numFrames?: number;
  /** Of all frames in seconds, ascending, where these can be known; else null. */
  times: Float64Array | null;
  /** Such as `'avc1.64001f'`; null where it is not known. */
  codec: string | null;
  /** Whether frames can be decoded here; if not, facts are those that the container says. */
  decodable: boolean;
}

/**
 * A frame that is not read yet: `read` gives its pixels, a file, or an image that whoever asks for it closes; `close` gives
 * up whatever holds it, read or not.
 * `isGuess` where nothing says how long it is shown; `clip` where it is of one of several.
 */
export type TimedFrame = {
  time: number;
  duration: number;
  read: () => Promise<ReadFrame>;
  close: () => void;
  isGuess?: boolean;
  clip?: string;
};

/**
 * A source of frames. `frames` gives them in the order of their times, those before `start` left out or not; `times`
 * gives the times of all frames where they are known without decoding; `at` the frames at ascending times of frames,
 * where that takes less than going through all.
 */
export interface Reader {
  info: () => Promise<Omit<VideoInfo, 'times'>>;
  frames: (range: { start: number; end: number }) => AsyncGenerator<TimedFrame, void, unknown>;
  times: () => Promise<Float64Array | null>;
  at?: (times: number[]) => AsyncGenerator<TimedFrame, void, unknown>;
  /** What `frames` end with, where `info` has found it. */
  damage?: TraceCutError;
  close: () => void;
}

/**
 * A frame that is read; an image is there until the next is asked for. `end` is when it ends, in seconds; null where nothing
 * says.
 */
export type TakenFrame = {
  raw: ReadFrame;
  index: number;
  time: number;
  duration: number;
  end: number | null;
  clip?: string;
};

/**
 * Times are often sums of rounded numbers: a frame this much before `start` is still in. WebCodecs counts microseconds.
 */
export const SLACK = 1e-6;

/** Codes of damage, and the fewest frames before it that are worth having: motion needs two. */
const DAMAGE = ['truncated', 'decode', 'frame-bytes'];
export const FEWEST = 2;

/**
 * The frames of a reader that are wanted; each is closed as soon as it is read. Where the take knows what to
 * do with damage, they end before it; where its signal aborts, with its reason.
 */
export async function* taken(reader: Reader, take: Take): AsyncGenerator<TakenFrame, void, unknown> {
  const frames = wanted(reader, take);
  let index = 0;
  try {
    for (;;) {
      const { value, done } = await untilAborted(frames.next(), take.signal);
      if (done) return;
      yield value;
      index += 1;
    }
  } catch (error) {
    if (!isDamage(error)) throw error;
    error.frames = index;
    if (!take.onDamage || index < FEWEST) throw error;
    take.onDamage({ frames: index, total: await expected(reader, take).catch(() => null), error });
  } finally {
    frames.return().catch(() => {});
  }
}

export function isDamage(error: unknown): error is TraceCutError {
  return error instanceof TraceCutError && DAMAGE.includes(error.code);
}

async function* wanted(reader: Reader, take: Take): AsyncGenerator<TakenFrame, void, unknown> {
  let passed = 0;
  let index = 0;
  let present: string | undefined;
  for await (const frame of reader.frames(take)) {
    try {
      if (frame.time < take.start - SLACK) continue;
      const { clip } = frame;
      if (frame.time >= take.end - SLACK) {
        if (clip === undefined) return;
        continue;
      }
      if (clip !== present) [present, passed] = [clip, 0];
      passed += 1;
      if ((passed - 1) % take.step !== 0) continue;
      const read = await frame.read();
      frame.close();
      // Whether a file is damaged shows when it is decoded.
      const raw = take.onDamage && read.kind === 'file' ? await decoded(read) : read;
      const { time, duration } = frame;
      // Frames that are left out lengthen those before them; nobody knows how many would have come after the last.
      const isKnown = duration > 0 && !frame.isGuess && take.step === 1;
      const end = isKnown ? time + duration : null;
      try {
        yield { raw, index, time, duration, end, ...(clip === undefined ? {} : { clip }) };
      } finally {
        // Whoever stopped waiting for it did not see it.
        if (raw.kind === 'image') raw.image.close();
      }
      index += 1;
      if (index >= take.maxFrames) return;
    } finally {
      frame.close();
    }
  }
}

async function decoded(raw: RawFrame): Promise<RawFrame> {
  return { kind: 'pixels', ...(await pixelsFrom(raw)) };
}

/** How many frames `taken` will give, where that can be known. */
export async function expected(reader: Reader, { start, end, step, maxFrames }: Take): Promise<number | null> {
  const times = await reader.times();
  if (!times) return null;
  const inRange = times.filter((time) => time >= start - SLACK && time < end - SLACK).length;
  return Math.min(maxFrames, Math.ceil(inRange / step));
}

/** The error of a take that holds nothing. */
export async function nothingTaken({ start, end }: Take, reader: Reader) {
  if (start === -Infinity && end === Infinity) return new TraceCutError('no-frames', 'the source has no frames');
  const times = await reader.times().catch(() => null);
  const last = times?.[times.length - 1];
  const known = times && last !== undefined ? `; its frames are at ${round(times[0])} s to ${round(last)} s` : '';
  const range = `${start > -Infinity ? ` from ${start} s` : ''}${end < Infinity ? ` to ${end} s` : ' on'}`;
  return new TraceCutError('no-frames', `the source has no frame${range}${known}`);
}

const round = (time: number | undefined = 0) => Number(time.toFixed(3));

/**
 * What is taken of a source: the frames whose time lies in `[start, end)`, every `step`-th of them, at most
 * `maxFrames`.
 */
export interface TakeOptions {
  /** Seconds; the clip's begin if not given. */
  start?: number;
  /** Seconds; the clip's end if not given. */
  end?: number;
  /** Every `step`-th frame; 1 if not given. */
  step?: number;
  /** The largest number of frames; all if not given. */
  maxFrames?: number;
  /** The long side in pixels that frames are reduced to; a smaller frame stays as it is. */
  size?: number;
  /** Frames per second of a list of frames that carry no times; 25 if not given. */
  frameRate?: number;
  /** Where the wasm file is that reads PNG and JPEG files, when not beside the package. */
  decoder?: WasmSource;
  /** Ends the work: what is awaited rejects with its reason. */
  signal?: AbortSignal;
  /**
   * With it, a source that is cut off or damaged ends before the damage, which this is told of; without it, and where
   * fewer than two frames come before, the frames before are followed by an error (`truncated`, `decode`) whose
   * `frames` is their number.
   */
  onDamage?: (damage: Damage) => void;
}

/**
 * Damage that a source ends with: how many frames were taken before it, how many should have been, null where nobody
 * knows, and what is wrong.
 */
export type Damage = { frames: number; total: number | null; error: TraceCutError };

export interface Take {
  start: number;
  end: number;
  step: number;
  maxFrames: number;
  size: number | undefined;
  frameRate: number;
  signal: AbortSignal | undefined;
  onDamage: ((damage: Damage) => void) | undefined;
}

const MAX_FRAMES = 1_000_000;

export function asOptions(options: unknown): Record<string, unknown> {
  if (options === undefined) return {};
  if (!isPlainObject(options))
    throw illegal('param', 'options', options, 'an object such as {start: 0, end: 2, size: 480}');
  return options;
}

/** Checks what both `videoFrames` and `segmentVideo` take, and gives what is left. */
export function splitTake(options: Record<string, unknown>): { take: Take; others: Record<string, unknown> } {
  const {
    start = -Infinity,
    end = Infinity,
    step = 1,
    maxFrames = Infinity,
    size,
    frameRate = 25,
    signal,
    onDamage,
    ...others
  } = options;
  if (start !== -Infinity) seconds('start', start);
  if (end !== Infinity) seconds('end', end);
  if (Number(end) <= Number(start)) throw illegal('param', 'end', end, `more than start = ${start}`);
  wholeNumber('param', 'step', step, 1, MAX_FRAMES);
  if (maxFrames !== Infinity) wholeNumber('param', 'maxFrames', maxFrames, 1, MAX_FRAMES);
  if (size !== undefined) wholeNumber('param', 'size', size, 16, MAX_SIDE);
  if (typeof frameRate !== 'number' || !(frameRate > 0 && frameRate <= 1000)) {
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0 and at most 1000');
  }
  if (signal !== undefined && !isSignal(signal)) throw illegal('param', 'signal', signal, 'an AbortSignal');
  if (onDamage !== undefined && typeof onDamage !== 'function')
    throw illegal('param', 'onDamage', onDamage, 'a function of what was damaged');
  const take = { start, end, step, maxFrames, size, frameRate, signal, onDamage } as Take;
  return { take, others };
}

/** Returns `overlap` if it was given. */
export function splitWindow(options: Record<string, unknown>): {
  window: number;
  overlap: number | undefined;
  others: Record<string, unknown>;
} {
  const { window = WINDOWS.frames, overlap, ...others } = options;
  const frames = wholeNumber('param', 'window', window, 2, WINDOWS.most);
  const shared = overlap === undefined ? undefined : wholeNumber('param', 'overlap', overlap, 1, frames - 1);
  return { window: frames, overlap: shared, others };
}

function seconds(name: string, value: unknown) {
  if (typeof value !== 'number' || !Number.isFinite(value)) throw illegal('param', name, value, 'a number of seconds');
}

function isSignal(signal: unknown): signal is AbortSignal {
  return typeof signal === 'object' && signal !== null && 'aborted' in signal && 'addEventListener' in signal;
}
