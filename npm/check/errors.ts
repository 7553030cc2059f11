// The one error of the package, what its messages are put together from, and checks of values that throw it.

import type { VideoResult } from '../video/result.js';

/**
 * The kinds of {@link TraceCutError}. From Rust: `frame-size`, `frame-bytes`, `frame-size-changed`, `too-few-frames`,
 * `too-large` (more than a parameter such as `clip.maxPixels` allows), `decode`, `param`, `data`, `state`. From this
 * layer: `unsupported` (the engine lacks something), `wasm-load` (the wasm file cannot be fetched or compiled), `memory`
 * (the session ran out of memory and has freed its own), `poisoned` (the engine stopped on an internal error), `closed`,
 * `busy`. From videos: `no-video` (nothing in it can be shown), `codec` (it cannot be decoded here), `truncated` (cut
 * off or damaged), `no-frames` (none in the range), `fetch` (the address cannot be fetched).
 */
export type ErrorCode =
  | 'frame-size'
  | 'frame-bytes'
  | 'frame-size-changed'
  | 'too-few-frames'
  | 'too-large'
  | 'decode'
  | 'param'
  | 'data'
  | 'state'
  | 'unsupported'
  | 'wasm-load'
  | 'memory'
  | 'poisoned'
  | 'closed'
  | 'busy'
  | 'no-video'
  | 'codec'
  | 'truncated'
  | 'no-frames'
  | 'fetch';

/**
 * An error with a stable `code` and a message that names the value and what is legal. All errors of the package are of this
 * class. Others pass unchanged: the reason of a signal that aborted (by default a `DOMException` named `AbortError`), and
 * errors that the caller's source of frames or callbacks throw.
 */
export class TraceCutError extends Error {
  /** The result of the frames before the damage, set by `collect`. */
  result: VideoResult | undefined;

  name = 'TraceCutError';
  /** The kind of error. It is stable, unlike the message. */
  code: ErrorCode;
  /** Number of whole frames before the damage (`truncated`); undefined if unknown. */
  frames: number | undefined;

  constructor(code: ErrorCode, message: string, options?: { cause?: unknown; frames?: number }) {
    super(message, options);
    this.code = code;
    this.frames = options?.frames;
  }
}

/** Rethrows an error that Rust returned, which has a code, as a `TraceCutError`. */
export function throwIfRust(error: unknown) {
  if (error instanceof Error && 'code' in error && typeof error.code === 'string')
    throw new TraceCutError(error.code as ErrorCode, error.message);
}

/** Creates the error for an invalid value. */
export function illegal(code: ErrorCode, name: string, value: unknown, expected: string) {
  return new TraceCutError(code, `${name} = ${describe(value)} (expected ${expected})`);
}

/** Creates the error for a value above a limit that a parameter sets, worded as in Rust. */
export function tooLarge(actual: number, unit: string, limit: number, name: string) {
  return new TraceCutError(
    'too-large',
    `${actual} ${unit} (expected at most ${limit}; the parameter ${name} sets this limit)`,
  );
}

/** Describes a value briefly, for messages. */
export function describe(value: unknown): string {
  if (typeof value === 'string') return value.length > 40 ? `"${value.slice(0, 40)}..."` : `"${value}"`;
  if (typeof value === 'function') return 'a function';
  if (Array.isArray(value)) return `a list of ${value.length}`;
  if (ArrayBuffer.isView(value)) return `${typeTag(value)} of ${value.byteLength} bytes`;
  if (typeof value === 'object' && value !== null) {
    const tag = typeTag(value);
    return `${/^[AEIOU]/.test(tag) ? 'an' : 'a'} ${tag}`;
  }
  return String(value);
}

/** Returns the name of a built-in type, also for objects of another realm: `Uint8Array`, `VideoFrame`, `Object`... */
export function typeTag(value: unknown) {
  return Object.prototype.toString.call(value).slice(8, -1);
}

/** Adds the number or name of a frame to an error, if known. */
export function withFrame(error: unknown, { index, name }: { kind?: string; index?: number; name?: string }) {
  if (!(error instanceof TraceCutError) || (index ?? name) === undefined) return error;
  const where = index === undefined ? name : `frame ${index}${name ? ` (${name})` : ''}`;
  return new TraceCutError(error.code, `${where}: ${error.message}`, { cause: error });
}

export function isPlainObject<T>(value: T): value is T & Record<string, unknown> {
  return typeof value === 'object' && value !== null && typeTag(value) === 'Object';
}

/** Returns the value; throws unless it is a whole number in `min..=max`. */
export function checkWholeNumber(code: ErrorCode, name: string, value: unknown, min: number, max: number): number {
  if (typeof value !== 'number' || !Number.isInteger(value) || value < min || value > max) {
    throw illegal(code, name, value, `a whole number, ${min}..=${max}`);
  }
  return value;
}

/** Most pixels along a side of a frame or mask. Rust has the same limit. */
export const MAX_SIDE = 16384;

/**
 * Throws unless both sides of a size are in `1..=MAX_SIDE`.
 * @param prefix of `width` and `height` in the error
 */
export function checkSides(code: ErrorCode, prefix: string, size: { width?: unknown; height?: unknown }) {
  checkWholeNumber(code, `${prefix}width`, size.width, 1, MAX_SIDE);
  checkWholeNumber(code, `${prefix}height`, size.height, 1, MAX_SIDE);
}

/**
 * Returns the options; throws if they are no object or have unknown names. Every public function with options calls it.
 * @param legal names of all options of the call
 * @param place.prefix of the names in the error, for an object inside of options
 * @param place.nested further names that may have been meant
 */
export function checkOptions<T extends object>(
  options: T,
  legal: readonly string[],
  { prefix = '', nested = [] }: { prefix?: string; nested?: readonly string[] } = {},
): T {
  if (!isPlainObject(options)) {
    const name = prefix ? prefix.slice(0, -1) : 'options';
    throw illegal('param', name, options, `an object with ${legal.join(', ')}`);
  }
  const unknown = Object.keys(options).find((key) => !legal.includes(key));
  if (unknown !== undefined) {
    const names = legal.map((name) => prefix + name);
    const similar = findSimilar(unknown, [...names, ...nested]);
    const hint = similar === undefined ? '' : `, such as ${similar}`;
    throw illegal(
      'param',
      prefix + unknown,
      options[unknown],
      `a known option${hint}; the options are ${names.join(', ')}`,
    );
  }
  return options;
}

/** Returns the name that was probably meant: its last part differs in case or in a few letters; undefined if none does. */
function findSimilar(name: string, candidates: readonly string[]): string | undefined {
  const distances = candidates.map((candidate) => {
    const last = candidate.slice(candidate.lastIndexOf('.') + 1);
    return countEdits(name.toLowerCase(), last.toLowerCase());
  });
  const least = Math.min(...distances);
  return least <= Math.max(1, name.length / 3) ? candidates[distances.indexOf(least)] : undefined;
}

/** Counts the letters to insert, delete, replace or swap with the next one to get from one word to another. */
function countEdits(from: string, to: string): number {
  const rows = [Array.from({ length: to.length + 1 }, (_, j) => j)];
  for (let i = 1; i <= from.length; i += 1) {
    const [row, last, lastButOne] = [[i], rows[i - 1]!, rows[i - 2]];
    for (let j = 1; j <= to.length; j += 1) {
      const isSwap = lastButOne && from[i - 1] === to[j - 2] && from[i - 2] === to[j - 1];
      row[j] = Math.min(
        last[j]! + 1,
        row[j - 1]! + 1,
        last[j - 1]! + Number(from[i - 1] !== to[j - 1]),
        isSwap ? lastButOne[j - 2]! + 1 : Infinity,
      );
    }
    rows.push(row);
  }
  return rows[from.length]![to.length]!;
}

/** Throws unless the value is true or false. */
export function checkFlag(name: string, value: unknown) {
  if (typeof value !== 'boolean')
    throw new TraceCutError('param', `${name} = ${describe(value)} (expected true or false)`);
}

/** Throws unless the value is a number in `min..=max`. */
export function checkNumber(name: string, value: unknown, min: number, max: number) {
  if (typeof value !== 'number' || !(value >= min && value <= max))
    throw illegal('param', name, value, `a number, ${min}..=${max}`);
}

export function checkChoice(name: string, value: unknown, legal: readonly string[]) {
  if (!legal.includes(value as string))
    throw illegal('param', name, value, legal.map((word) => `'${word}'`).join(', '));
}

export function isIterable(frames: unknown) {
  return typeof frames === 'object' && frames !== null && (Symbol.iterator in frames || Symbol.asyncIterator in frames);
}
