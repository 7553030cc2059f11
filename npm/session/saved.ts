// Results as plain objects for JSON: typed arrays as text. Words are written as differences from the one before, byte by
// byte, and packed by a range coder whose odds adapt to what came before: the same bytes on every machine.

import { TraceCutError, checkSides, illegal, isPlainObject } from '../check/errors.js';
import { VERSION } from '../parameters.js';

/** Odds that a bit is 0, of 2048, and how fast they adapt. */
const [EVEN, ALL_BITS, RATE] = [1024, 11, 5];
const TOP = 2 ** 32;

const KINDS = { Uint8Array, Int32Array, Uint32Array, Float32Array, Float64Array };

/** A result's fields for JSON. */
export function saved(fields: object): Record<string, unknown> {
  return packed({ tracecut: VERSION, ...fields }) as Record<string, unknown>;
}

/**
 * The fields of a result that was saved or cloned.
 * @returns `needed` are there, `width` and `height` are sizes
 */
export function opened<T extends { width: number; height: number }>(json: unknown, needed: string[]): T {
  let found = json;
  try {
    if (typeof json === 'string') found = JSON.parse(json);
  } catch (cause) {
    throw new TraceCutError('data', 'the saved result is damaged: it is no JSON', { cause });
  }
  found = unpacked(found);
  const fields = isPlainObject(found) ? found : undefined;
  const missing = fields ? needed.find((name) => fields[name] === undefined) : 'a result';
  if (missing !== undefined) throw illegal('data', 'json', json, `a saved result of this kind; it has no ${missing}`);
  const result = found as T;
  checkSides('data', '', result);
  return result;
}

export type PackedArray = { array: string; length: number; data: string };

/** The same value with texts in place of typed arrays. */
function packed(value: unknown): unknown {
  if (ArrayBuffer.isView(value)) {
    const bytes = new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
    const array = Object.prototype.toString.call(value).slice(8, -1);
    return { array, length: bytes.length, data: text(coded(bytes, array === 'Uint8Array' ? 1 : 4)) };
  }
  if (Array.isArray(value)) return value.map(packed);
  if (!isPlainObject(value)) return value;
  return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, packed(inner)]));
}

/** What `packed` was made of. */
function unpacked(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(unpacked);
  if (!isPlainObject(value)) return value;
  const { array, length, data } = value;
  const Kind = KINDS[array as keyof typeof KINDS];
  if (!Kind || typeof data !== 'string')
    return Object.fromEntries(Object.entries(value).map(([name, inner]) => [name, unpacked(inner)]));
  if (!Number.isInteger(length) || Number(length) % Kind.BYTES_PER_ELEMENT !== 0 || !(Number(length) <= 64 * MOST))
    throw illegal('data', 'the length of an array', length, `a multiple of ${Kind.BYTES_PER_ELEMENT}`);
  return new Kind(decoded(bytesOf(data), Number(length), array === 'Uint8Array' ? 1 : 4).buffer);
}

/** Arrays of more bytes are none of ours. */
const MOST = 2 ** 25;

/** The odds of each bit of a byte, by its place in the word and by whether the byte above it is 0, 255 or another. */
class Odds {
  odds = new Uint16Array(4 * 3 * 256).fill(EVEN);
  above = 0;

  /** @param bit codes one by the odds of that index */
  byte(plane: number, bit: (index: number) => number) {
    const base = (plane * 3 + this.above) * 256;
    let node = 1;
    while (node < 256) node = 2 * node + bit(base + node);
    const byte = node & 255;
    this.above = byte === 0 ? 0 : byte === 255 ? 1 : 2;
    return byte;
  }

  learn(index: number, bit: number) {
    const odds = Number(this.odds[index]);
    this.odds[index] = bit ? odds - (odds >> RATE) : odds + ((2 ** ALL_BITS - odds) >> RATE);
  }
}

/**
 * Codes the words of `size` bytes, highest byte first, each by `byte`, which is told the difference's byte or tells it.
 * @param isThere whether the bytes are known, or are to be
 */
function eachWord(bytes: Uint8Array, size: number, byte: (plane: number, byte: number) => number, isThere: boolean) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let before = 0;
  for (let at = 0; at < bytes.length; at += size) {
    const word = isThere ? (size === 1 ? view.getUint8(at) : view.getUint32(at, true)) : 0;
    const difference = (word - before) >>> 0;
    let made = 0;
    for (let plane = size - 1; plane >= 0; plane -= 1)
      made = (made * 256 + byte(plane, (difference >>> (8 * plane)) & 255)) >>> 0;
    before = (before + made) >>> 0;
    if (size === 1) view.setUint8(at, before & 255);
    else if (!isThere) view.setUint32(at, before, true);
  }
}

/** @param size of its words in bytes */
function coded(source: Uint8Array, size: number): Uint8Array {
  const odds = new Odds();
  const out: number[] = [];
  let [low, range, cache, pending] = [0, TOP - 1, 0, 1];
  const shift = () => {
    if (low < 0xff000000 || low >= TOP) {
      const carry = low >= TOP ? 1 : 0;
      for (; pending > 0; pending -= 1, cache = 255) out.push((cache + carry) & 255);
      cache = (low >>> 24) & 255;
    }
    pending += 1;
    low = (low % 2 ** 24) * 256;
  };
  const put = (index: number, bit: number) => {
    const bound = (range >>> ALL_BITS) * Number(odds.odds[index]);
    if (bit) low += bound;
    range = bit ? range - bound : bound;
    odds.learn(index, bit);
    for (; range < 2 ** 24; range *= 256) shift();
    return bit;
  };
  const byte = (plane: number, value: number) => {
    let left = 8;
    return odds.byte(plane, (index) => put(index, (value >> (left -= 1)) & 1));
  };
  eachWord(source.slice(), size, byte, true);
  for (let k = 0; k < 5; k += 1) shift();
  return Uint8Array.from(out);
}

/**
 * @param length of what it was made of
 * @param size of its words in bytes
 */
function decoded(source: Uint8Array, length: number, size: number) {
  const odds = new Odds();
  let [at, code, range] = [0, 0, TOP - 1];
  const more = () => {
    if (at >= source.length + 5) throw new TraceCutError('data', 'the saved result is cut off');
    code = ((code << 8) | (source[at] ?? 0)) >>> 0;
    at += 1;
  };
  for (let k = 0; k < 5; k += 1) more();
  const get = (index: number) => {
    const bound = (range >>> ALL_BITS) * Number(odds.odds[index]);
    const bit = code < bound ? 0 : 1;
    if (bit) code = (code - bound) >>> 0;
    range = bit ? range - bound : bound;
    odds.learn(index, bit);
    for (; range < 2 ** 24; range *= 256) more();
    return bit;
  };
  const bytes = new Uint8Array(length);
  eachWord(bytes, size, (plane) => odds.byte(plane, get), false);
  return bytes;
}

function text(bytes: Uint8Array) {
  const parts = [];
  for (let from = 0; from < bytes.length; from += 4096)
    parts.push(String.fromCharCode(...bytes.subarray(from, from + 4096)));
  return btoa(parts.join(''));
}

function bytesOf(base64: string) {
  try {
    return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  } catch (cause) {
    throw new TraceCutError('data', 'the saved result is damaged: a text is not base64', { cause });
  }
}
