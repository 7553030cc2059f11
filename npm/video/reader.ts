// The interface of all sources of frames, and the selection of frames from them.

import { MAX_SIDE, TraceCutError, checkWholeNumber, illegal, isPlainObject } from '../check/errors.js';
import { WINDOWS } from '../parameters.js';
import { untilAborted } from '../worker/pause.js';
import { type ReadFrame, decodePixels } from './pixels.js';
import type { WasmSource } from '../check/options.js';
import type { RawFrame } from '../worker/frames.js';

/** Facts of a video. */
export interface VideoInfo {
  /** Width of the displayed frames in pixels. */
  width: number;
  height: number;
  /** Seconds from the start of the first frame to the end of the last; `Infinity` for a stream. */
  duration: number;
  /** Average frames per second, `numFrames / duration`; `NaN` if unknown. */
  frameRate: number;
  /** Number of frames, if known without decoding. */
  numFrames?: number;
  /** Times of all frames in seconds, ascending; null if unknown. */
  times: Float64Array | null;
  /** Codec string such as `'avc1.64001f'`; null if unknown. */
  codec: string | null;
  /** True if frames can be decoded here; if not, the other facts come from the container. */
  decodable: boolean;
}

/**
 * A frame that is not read yet: `read` returns its pixels, a file, or an image that the caller closes; `close` frees the
 * frame, read or not. `isGuess` marks an unknown duration; `clip` names its clip if there are several.
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
 * A source of frames. `frames` yields them by time, possibly including some before `start`; `times` returns the times of
 * all frames if they are known without decoding; `framesAt` yields the frames at ascending times, if that is faster than
 * reading all.
 */
export interface Reader {
  info: () => Promise<Omit<VideoInfo, 'times'>>;
  frames: (range: { start: number; end: number }) => AsyncGenerator<TimedFrame, void, unknown>;
  times: () => Promise<Float64Array | null>;
  framesAt?: (times: number[]) => AsyncGenerator<TimedFrame, void, unknown>;
  /** Error that `frames` ends with, once `info` has found it. */
  damage?: TraceCutError;
  close: () => void;
}

/**
 * A frame that is read; an image is valid until the next one is requested. `end` is the time at which it ends, in seconds;
 * null if unknown.
 */
export type SelectedFrame = {
  raw: ReadFrame;
  index: number;
  time: number;
  duration: number;
  end: number | null;
  clip?: string;
};

/** Tolerance of times, which are often sums of rounded numbers, in seconds. WebCodecs counts microseconds. */
export const TIME_TOLERANCE_S = 1e-6;

/** Error codes of damage, and the fewest frames before it that are of use: motion needs two. */
const DAMAGE_CODES = ['truncated', 'decode', 'frame-bytes'];
export const MIN_FRAMES = 2;

/**
 * Yields the selected frames of a reader; each is closed as soon as it is read. Damage ends them if the selection has
 * `onDamage`, an aborted signal with its reason.
 */
export async function* takeFrames(reader: Reader, take: Take): AsyncGenerator<SelectedFrame, void, unknown> {
  const frames = selectFrames(reader, take);
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
    if (!take.onDamage || index < MIN_FRAMES) throw error;
    take.onDamage({ frames: index, total: await countExpected(reader, take).catch(() => null), error });
  } finally {
    frames.return().catch(() => {});
  }
}

export function isDamage(error: unknown): error is TraceCutError {
  return error instanceof TraceCutError && DAMAGE_CODES.includes(error.code);
}

async function* selectFrames(reader: Reader, take: Take): AsyncGenerator<SelectedFrame, void, unknown> {
  let numSeen = 0;
  let index = 0;
  let currentClip: string | undefined;
  for await (const frame of reader.frames(take)) {
    let isOpen = true;
    const close = () => {
      if (isOpen) frame.close();
      isOpen = false;
    };
    try {
      if (frame.time < take.start - TIME_TOLERANCE_S) continue;
      const { clip } = frame;
      if (frame.time >= take.end - TIME_TOLERANCE_S) {
        if (clip === undefined) return;
        continue;
      }
      if (clip !== currentClip) [currentClip, numSeen] = [clip, 0];
      numSeen += 1;
      if ((numSeen - 1) % take.step !== 0) continue;
      const read = await frame.read();
      close();
      // Damage of a file is found when it is decoded.
      const raw = take.onDamage && read.kind === 'file' ? await decodeFile(read) : read;
      const { time, duration } = frame;
      // Skipped frames lengthen those before them; the number of frames after the last is unknown.
      const isKnown = duration > 0 && !frame.isGuess && take.step === 1;
      const end = isKnown ? time + duration : null;
      try {
        yield { raw, index, time, duration, end, ...(clip === undefined ? {} : { clip }) };
      } finally {
        // A caller that stopped waiting did not get it.
        if (raw.kind === 'image') raw.image.close();
      }
      index += 1;
      if (index >= take.maxFrames) return;
    } finally {
      close();
    }
  }
}

async function decodeFile(raw: RawFrame): Promise<RawFrame> {
  return { kind: 'pixels', ...(await decodePixels(raw)) };
}

/** Returns the number of frames that `takeFrames` will yield, if known. */
export async function countExpected(reader: Reader, { start, end, step, maxFrames }: Take): Promise<number | null> {
  const times = await reader.times();
  if (!times) return null;
  const inRange = times.filter((time) => time >= start - TIME_TOLERANCE_S && time < end - TIME_TOLERANCE_S).length;
  return Math.min(maxFrames, Math.ceil(inRange / step));
}

/** Creates the error for a selection without frames. */
export async function createEmptyError({ start, end }: Take, reader: Reader) {
  if (start === -Infinity && end === Infinity) return new TraceCutError('no-frames', 'the source has no frames');
  const times = await reader.times().catch(() => null);
  const last = times?.[times.length - 1];
  const available = times && last !== undefined ? `; its frames are at ${round(times[0])} s to ${round(last)} s` : '';
  const range = `${start > -Infinity ? ` from ${start} s` : ''}${end < Infinity ? ` to ${end} s` : ' on'}`;
  return new TraceCutError('no-frames', `the source has no frame${range}${available}`);
}

const round = (time: number | undefined = 0) => Number(time.toFixed(3));

/**
 * Selection of frames from a source: the frames whose time lies in `[start, end)`, every `step`-th of them, at most
 * `maxFrames`.
 */
export interface TakeOptions {
  /** Start in seconds; the clip's start if not given. */
  start?: number;
  /** End in seconds; the clip's end if not given. */
  end?: number;
  /** Takes every `step`-th frame; 1 if not given. */
  step?: number;
  /** Most frames; all if not given. */
  maxFrames?: number;
  /** Longer side in pixels that frames are reduced to; smaller frames stay as they are. */
  size?: number;
  /** Frames per second of a list of frames without times; 25 if not given. */
  frameRate?: number;
  /** The wasm file that decodes PNG and JPEG, if it is not beside the package. */
  decoder?: WasmSource;
  /** Aborts the work: pending promises reject with its reason. */
  signal?: AbortSignal;
  /**
   * Called if a source is cut off or damaged; the frames then end before the damage. Without it, or if fewer than two
   * frames come before the damage, they are followed by an error (`truncated`, `decode`) whose `frames` is their number.
   */
  onDamage?: (damage: Damage) => void;
}

/**
 * Damage that ends a source: the number of frames taken before it, the number that was expected, null if unknown, and the
 * error.
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

/** Names of the options that `splitTake` and `splitWindow` check. */
export const TAKE_NAMES = ['start', 'end', 'step', 'maxFrames', 'size', 'frameRate', 'signal', 'onDamage'];
export const WINDOW_NAMES = ['window', 'overlap'];

/** Largest `step` and `maxFrames`. */
const MAX_FRAMES = 1_000_000;

export function asOptions(options: unknown): Record<string, unknown> {
  if (options === undefined) return {};
  if (!isPlainObject(options))
    throw illegal('param', 'options', options, 'an object such as {start: 0, end: 2, size: 480}');
  return options;
}

/** Checks the options that select frames, and returns the others separately. */
export function splitTake(options: object): { take: Take; others: Record<string, unknown> } {
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
  } = options as Record<string, unknown>;
  if (start !== -Infinity) checkSeconds('start', start);
  if (end !== Infinity) checkSeconds('end', end);
  if (Number(end) <= Number(start)) throw illegal('param', 'end', end, `more than start = ${start}`);
  checkWholeNumber('param', 'step', step, 1, MAX_FRAMES);
  if (maxFrames !== Infinity) checkWholeNumber('param', 'maxFrames', maxFrames, 1, MAX_FRAMES);
  if (size !== undefined) checkWholeNumber('param', 'size', size, 16, MAX_SIDE);
  if (typeof frameRate !== 'number' || !(frameRate > 0 && frameRate <= 1000)) {
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0 and at most 1000');
  }
  if (signal !== undefined && !isSignal(signal)) throw illegal('param', 'signal', signal, 'an AbortSignal');
  if (onDamage !== undefined && typeof onDamage !== 'function')
    throw illegal('param', 'onDamage', onDamage, 'a function of what was damaged');
  const take = { start, end, step, maxFrames, size, frameRate, signal, onDamage } as Take;
  return { take, others };
}

/** Checks the options of windows; `overlap` stays undefined if not given. */
export function splitWindow(options: Record<string, unknown>): {
  window: number;
  overlap: number | undefined;
  others: Record<string, unknown>;
} {
  const { window = WINDOWS.frames, overlap, ...others } = options;
  const frames = checkWholeNumber('param', 'window', window, 2, WINDOWS.most);
  const checkedOverlap =
    overlap === undefined ? undefined : checkWholeNumber('param', 'overlap', overlap, 1, frames - 1);
  return { window: frames, overlap: checkedOverlap, others: others };
}

function checkSeconds(name: string, value: unknown) {
  if (typeof value !== 'number' || !Number.isFinite(value)) throw illegal('param', name, value, 'a number of seconds');
}

function isSignal(signal: unknown): signal is AbortSignal {
  return typeof signal === 'object' && signal !== null && 'aborted' in signal && 'addEventListener' in signal;
}
