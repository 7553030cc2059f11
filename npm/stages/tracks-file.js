// `tracks.dat`, the track file of the Moseg benchmark, read.

import { TraceCutError, checkSides, illegal, wholeNumber } from '../check/errors.js';

/**
 * The trajectories of a track file, as `setTrajectories` takes them, each with its label.
 * @typedef {{numFrames: number, width: number, height: number, count: number, startFrame: Uint32Array<ArrayBuffer>,
 *   offset: Uint32Array<ArrayBuffer>, x: Float32Array<ArrayBuffer>, y: Float32Array<ArrayBuffer>,
 *   label: Uint32Array<ArrayBuffer>}} TrackFile
 */

const MAX_FRAMES = 100000;
const MAX_COUNT = 2 ** 31;

/**
 * Reads a track file. How large the frames are is not in it.
 *
 * ```js
 * await session.setTrajectories(await fromTracksDat(text, { width: 640, height: 480 }));
 * ```
 * @param {string} text
 * @param {{readonly width: number, readonly height: number}} size of the frames in pixels
 * @returns {Promise<TrackFile>}
 */
export async function fromTracksDat(text, size) {
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

/**
 * @param {Lines} lines
 * @param {number} numFrames
 * @param {{label: number[], startFrame: number[], offset: number[], x: number[], y: number[]}} read
 */
function readTrack(lines, numFrames, { label, startFrame, offset, x, y }) {
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

  /** @param {string} text */
  constructor(text) {
    this.#text = text;
  }

  /** @param {string} expected */
  next(expected) {
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

  /**
   * @param {string[]} words
   * @param {number} number
   */
  constructor(words, number) {
    this.#words = words;
    this.#number = number;
  }

  /** @param {string} expected */
  number(expected) {
    const word = this.#words[this.#next++] ?? '';
    const value = Number(word);
    if (word === '' || !Number.isFinite(value)) throw this.error(`"${word}"`, `${expected}, a finite number`);
    return value;
  }

  /**
   * @param {string} expected
   * @param {number} min
   * @param {number} max
   */
  whole(expected, min, max) {
    const value = this.number(expected);
    if (Number.isInteger(value) && value >= min && value <= max) return value;
    throw this.error(String(value), `${expected}, ${min}..=${max}`);
  }

  /**
   * @param {string} found
   * @param {string} expected
   */
  error(found, expected) {
    return new TraceCutError('data', `line ${this.#number} of the track file: ${found} (expected ${expected})`);
  }
}
