// Labels as run lengths, a 32-bit number for each run of equal pixels in a row; and results as plain objects for JSON: typed
// arrays as text. Words are written as differences to the word before, byte by byte, and compressed by a range coder with
// adaptive odds: the same bytes on every machine.

import { TraceCutError, checkSides, illegal, isPlainObject } from '../check/errors.js';
import { VERSION } from '../parameters.js';

/** Labels of a frame as runs of equal pixels, row by row: the label in the lowest 8 bits, the length above. */
export type Runs = Uint32Array<ArrayBuffer>;

/** Bits of the label in a run. */
const LABEL_BITS = 8;
const NUM_LABELS = 2 ** LABEL_BITS;
/** Longest run; longer ones are split. */
const MAX_RUN = 2 ** (32 - LABEL_BITS) - 1;

/**
 * Encodes labels as runs.
 * @param labels 0 to 255, row by row
 */
export function encodeRuns(labels: ArrayLike<number>): Runs {
  const runs: number[] = [];
  for (let from = 0; from < labels.length;) {
    const label = labels[from]!;
    let to = from + 1;
    while (to < labels.length && labels[to] === label && to - from < MAX_RUN) to += 1;
    runs.push((to - from) * NUM_LABELS + label);
    from = to;
  }
  return Uint32Array.from(runs);
}

/** Decodes runs to a label for each pixel. */
export function decodeRuns(runs: Runs): Uint8Array<ArrayBuffer> {
  const labels = new Uint8Array(sumLengths(runs));
  forEachRun(runs, (label, from, to) => labels.fill(label, from, to));
  return labels;
}

/**
 * Calls `visit` with each run, in order.
 * @param visit takes the label, the run's first pixel and the one after its last
 */
export function forEachRun(runs: Runs, visit: (label: number, from: number, to: number) => void) {
  let from = 0;
  for (const run of runs) {
    const to = from + (run >>> LABEL_BITS);
    visit(run % NUM_LABELS, from, to);
    from = to;
  }
}

/**
 * Counts the pixels of each label.
 * @returns 256 numbers
 */
export function countPixels(runs: Runs): Uint32Array<ArrayBuffer> {
  const areas = new Uint32Array(NUM_LABELS);
  forEachRun(runs, (label, from, to) => (areas[label] = Number(areas[label]) + to - from));
  return areas;
}

/** Throws unless the runs cover a frame. */
export function checkRuns(name: string, runs: unknown, size: number): Runs {
  if (!(runs instanceof Uint32Array)) throw illegal('data', name, runs, 'runs of pixels, a Uint32Array');
  const covered = sumLengths(runs as Runs);
  if (covered !== size) throw new TraceCutError('data', `${name} covers ${covered} pixels (expected ${size})`);
  return runs as Runs;
}

/** Concatenates the runs of all frames, each preceded by their number. */
export function joinRuns(frames: readonly Runs[]) {
  return joinWords(frames.flatMap((runs) => [Uint32Array.of(runs.length), runs]));
}

/** Splits the runs of `joinRuns` by frame. */
export function splitRuns(words: Uint32Array, numFrames: number): Runs[] {
  let end = 0;
  return Array.from({ length: numFrames }, () => {
    const from = end + 1;
    end = from + (words[end] ?? 0);
    return words.slice(from, end);
  });
}

export function joinWords(parts: readonly Uint32Array[]) {
  const words = new Uint32Array(parts.reduce((sum, { length }) => sum + length, 0));
  let end = 0;
  for (const part of parts) {
    words.set(part, end);
    end += part.length;
  }
  return words;
}

function sumLengths(runs: Runs) {
  return runs.reduce((sum, run) => sum + (run >>> LABEL_BITS), 0);
}

/** Initial odds that a bit is 0, of 2 ** `ODDS_BITS`, and the shift by which they adapt, as in LZMA. */
const [INITIAL_ODDS, ODDS_BITS, ADAPTATION_SHIFT] = [1024, 11, 5];
/** End of the range coder's interval. */
const RANGE_END = 2 ** 32;

const ARRAY_TYPES = { Uint8Array, Int32Array, Uint32Array, Float32Array, Float64Array };

/** Converts a result's fields for JSON. */
export function toSaved(fields: object): Record<string, unknown> {
  return packArrays({ tracecut: VERSION, ...fields }) as Record<string, unknown>;
}

/**
 * Restores the fields of a saved or cloned result.
 * @returns with all fields of `needed` and a valid `width` and `height`
 */
export function restoreFields<T extends { width: number; height: number }>(json: unknown, needed: string[]): T {
  let value = json;
  try {
    if (typeof json === 'string') value = JSON.parse(json);
  } catch (cause) {
    throw new TraceCutError('data', 'the saved result is damaged: it is no JSON', { cause });
  }
  value = unpackArrays(value);
  const fields = isPlainObject(value) ? value : undefined;
  const missing = fields ? needed.find((name) => fields[name] === undefined) : 'a result';
  if (missing !== undefined) throw illegal('data', 'json', json, `a saved result of this kind; it has no ${missing}`);
  const result = value as T;
  checkSides('data', '', result);
  return result;
}

/** Replaces typed arrays by texts. */
function packArrays(value: unknown): unknown {
  if (ArrayBuffer.isView(value)) {
    const bytes = new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
    const array = Object.prototype.toString.call(value).slice(8, -1);
    return { array, length: bytes.length, data: toBase64(encode(bytes, array === 'Uint8Array' ? 1 : 4)) };
  }
  if (Array.isArray(value)) return value.map(packArrays);
  if (!isPlainObject(value)) return value;
  return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, packArrays(inner)]));
}

/** Restores the typed arrays of `packArrays`. */
function unpackArrays(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(unpackArrays);
  if (!isPlainObject(value)) return value;
  const { array, length, data } = value;
  const Kind = ARRAY_TYPES[array as keyof typeof ARRAY_TYPES];
  if (!Kind || typeof data !== 'string')
    return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, unpackArrays(inner)]));
  if (!Number.isInteger(length) || Number(length) % Kind.BYTES_PER_ELEMENT !== 0 || !(Number(length) <= 64 * MOST))
    throw illegal('data', 'the length of an array', length, `a multiple of ${Kind.BYTES_PER_ELEMENT}`);
  return new Kind(decode(fromBase64(data), Number(length), array === 'Uint8Array' ? 1 : 4).buffer);
}

/** Largest array that is restored, in 64ths of its size in bytes: 2 GiB. */
const MOST = 2 ** 25;

/** Odds of each bit of a byte, by its position in the word and by the byte above it: 0, 255 or another. */
class Odds {
  odds = new Uint16Array(4 * 3 * 256).fill(INITIAL_ODDS);
  above = 0;

  /** @param bit codes a bit by the odds of this index */
  codeByte(plane: number, bit: (index: number) => number) {
    const base = (plane * 3 + this.above) * 256;
    let node = 1;
    while (node < 256) node = 2 * node + bit(base + node);
    const byte = node & 255;
    this.above = byte === 0 ? 0 : byte === 255 ? 1 : 2;
    return byte;
  }

  adapt(index: number, bit: number) {
    const odds = Number(this.odds[index]);
    this.odds[index] = bit ? odds - (odds >> ADAPTATION_SHIFT) : odds + ((2 ** ODDS_BITS - odds) >> ADAPTATION_SHIFT);
  }
}

/**
 * Codes the words of `size` bytes as differences, highest byte first; `byte` codes one byte of a difference.
 * @param isThere true to encode `bytes`, false to decode into them
 */
function codeWords(
  bytes: Uint8Array,
  size: number,
  byte: (plane: number, byte: number) => number,
  isEncoding: boolean,
) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let before = 0;
  for (let offset = 0; offset < bytes.length; offset += size) {
    const word = isEncoding ? (size === 1 ? view.getUint8(offset) : view.getUint32(offset, true)) : 0;
    const difference = (word - before) >>> 0;
    let coded = 0;
    for (let plane = size - 1; plane >= 0; plane -= 1)
      coded = (coded * 256 + byte(plane, (difference >>> (8 * plane)) & 255)) >>> 0;
    before = (before + coded) >>> 0;
    if (size === 1) view.setUint8(offset, before & 255);
    else if (!isEncoding) view.setUint32(offset, before, true);
  }
}

/** @param size of a word in bytes */
function encode(source: Uint8Array, size: number): Uint8Array {
  const odds = new Odds();
  const out: number[] = [];
  let [low, range, cache, pending] = [0, RANGE_END - 1, 0, 1];
  const shift = () => {
    if (low < 0xff000000 || low >= RANGE_END) {
      const carry = low >= RANGE_END ? 1 : 0;
      for (; pending > 0; pending -= 1, cache = 255) out.push((cache + carry) & 255);
      cache = (low >>> 24) & 255;
    }
    pending += 1;
    low = (low % 2 ** 24) * 256;
  };
  const put = (index: number, bit: number) => {
    const bound = (range >>> ODDS_BITS) * Number(odds.odds[index]);
    if (bit) low += bound;
    range = bit ? range - bound : bound;
    odds.adapt(index, bit);
    for (; range < 2 ** 24; range *= 256) shift();
    return bit;
  };
  const byte = (plane: number, value: number) => {
    let bitsLeft = 8;
    return odds.codeByte(plane, (index) => put(index, (value >> (bitsLeft -= 1)) & 1));
  };
  codeWords(source.slice(), size, byte, true);
  for (let k = 0; k < 5; k += 1) shift();
  return Uint8Array.from(out);
}

/**
 * @param length of the result in bytes
 * @param size of a word in bytes
 */
function decode(source: Uint8Array, length: number, size: number) {
  const odds = new Odds();
  let [position, code, range] = [0, 0, RANGE_END - 1];
  const readByte = () => {
    if (position >= source.length + 5) throw new TraceCutError('data', 'the saved result is cut off');
    code = ((code << 8) | (source[position] ?? 0)) >>> 0;
    position += 1;
  };
  for (let k = 0; k < 5; k += 1) readByte();
  const get = (index: number) => {
    const bound = (range >>> ODDS_BITS) * Number(odds.odds[index]);
    const bit = code < bound ? 0 : 1;
    if (bit) code = (code - bound) >>> 0;
    range = bit ? range - bound : bound;
    odds.adapt(index, bit);
    for (; range < 2 ** 24; range *= 256) readByte();
    return bit;
  };
  const bytes = new Uint8Array(length);
  codeWords(bytes, size, (plane) => odds.codeByte(plane, get), false);
  return bytes;
}

function toBase64(bytes: Uint8Array) {
  const parts = [];
  for (let from = 0; from < bytes.length; from += 4096)
    parts.push(String.fromCharCode(...bytes.subarray(from, from + 4096)));
  return btoa(parts.join(''));
}

function fromBase64(base64: string) {
  try {
    return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  } catch (cause) {
    throw new TraceCutError('data', 'the saved result is damaged: a text is not base64', { cause });
  }
}
