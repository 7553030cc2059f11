// Frames for Node: uncompressed video as streams, and video files by an installed ffmpeg.

import { spawn } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import { TraceCutError, checkedOptions, illegal, tooLarge, wholeNumber } from '../check/errors.js';
import { MAX_PIXELS } from '../check/options.js';
import { RAW_FORMATS, framePixels, y4mHeader } from './pixels.js';

/**
 * Bytes as they come: a stream of Node such as `process.stdin` or `createReadStream(path)`, a `ReadableStream`, or any
 * other sequence of pieces.
 * @typedef {AsyncIterable<Uint8Array> | Iterable<Uint8Array>} ByteSource
 */

/** @typedef {import('../video/frames.js').DecodedFrame} DecodedFrame */

/**
 * What lies in a raw stream: frames one after the other.
 * @typedef {object} RawOptions
 * @property {number} width of a frame in pixels
 * @property {number} height of a frame in pixels
 * @property {'rgba' | 'bgra' | 'rgb24' | 'bgr24' | 'gray' | 'yuv420p' | 'yuv422p' | 'yuv444p'} format of a frame, called
 *   as ffmpeg's `-pix_fmt`
 * @property {number} [frameRate] in frames per second; 25 if not given
 * @property {number} [maxPixels] most pixels of a frame, 1 to 2^28; 2^26 if not given. Larger ones are refused
 *   (`too-large`) before memory is taken
 */

/**
 * How ffmpeg is called.
 * @typedef {object} FfmpegOptions
 * @property {string} [ffmpeg] the program; `'ffmpeg'` from the PATH if not given
 * @property {AbortSignal} [signal] ends it
 * @property {number} [maxPixels] as of {@link RawOptions}
 */

const MAX_SIDE = 16384;
/** Largest legal `maxPixels`, as of `clip.maxPixels`. */
const MOST_PIXELS = 2 ** 28;
/** Longest header line, in bytes: real ones are below 200. */
const MAX_LINE = 4096;
const NEWLINE = 10;
/** How much of what ffmpeg says is kept, in characters. */
const WORDS = 2000;

/**
 * The frames of a YUV4MPEG2 stream, eight bits, 4:2:0, 4:2:2, 4:4:4 or brightness only, by ITU-R BT.601 as the command
 * line reads them. An error names the frame.
 *
 * ```js
 * for await (const { frame } of framesOfY4m(process.stdin)) await session.push(frame);
 * ```
 * @param {ByteSource} source
 * @param {{maxPixels?: number}} [options] as of {@link RawOptions}
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
export async function* framesOfY4m(source, options = {}) {
  const { maxPixels } = checkedOptions(options, ['maxPixels']);
  const bytes = new Bytes(source);
  try {
    const line = await bytes.line('header');
    if (line === null) throw new TraceCutError('no-video', 'the Y4M stream is empty (expected a YUV4MPEG2 header)');
    const format = checkedSize(y4mHeader(line), maxPixels);
    for (let index = 0; ; index += 1) {
      const head = await bytes.line(`frame ${index}`);
      if (head === null) return;
      if (head.split(' ')[0] !== 'FRAME')
        throw new TraceCutError('decode', `frame ${index} of the Y4M stream does not start with FRAME`);
      const data = await bytes.frame(format.bytes, index);
      if (!data) throw cutOff(index, 0, format.bytes);
      yield timed(framePixels(format, data), index, format.frameRate);
    }
  } finally {
    await bytes.close();
  }
}

/**
 * The frames of a raw stream, such as `ffmpeg -f rawvideo` writes. Colour of YUV formats is by ITU-R BT.601 in the
 * limited range.
 * @param {ByteSource} source
 * @param {RawOptions} options
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
export async function* framesOfRaw(source, options) {
  const format = rawFormat(options);
  const bytes = new Bytes(source);
  try {
    for (let index = 0; ; index += 1) {
      const data = await bytes.frame(format.bytes, index);
      if (!data) return;
      yield timed(framePixels(format, data), index, format.frameRate);
    }
  } finally {
    await bytes.close();
  }
}

/**
 * The frames of a video file (MP4, MOV, WebM, …), decoded by ffmpeg (5.1 or later), which has to be installed: without
 * it, error `unsupported`. Frames are turned as the file says, and have its times. Leaving the loop ends ffmpeg.
 *
 * ```js
 * const result = await segmentVideo(framesOfVideo('clip.mp4'), { size: 480 }).collect();
 * ```
 * @param {string | URL} path
 * @param {FfmpegOptions} [options]
 * @returns {AsyncGenerator<DecodedFrame, void, undefined>}
 */
export async function* framesOfVideo(path, options = {}) {
  const { ffmpeg = 'ffmpeg', signal, maxPixels } = checkedOptions(options, ['ffmpeg', 'signal', 'maxPixels']);
  signal?.throwIfAborted();
  const program = new Ffmpeg(ffmpeg, inputOf(path));
  const abort = () => program.end();
  signal?.addEventListener('abort', abort);
  const bytes = new Bytes(program.output);
  try {
    let index = 0;
    for (; ; index += 1) {
      const size = await pamHeader(bytes, index, maxPixels);
      const data = size && (await bytes.frame(4 * size.width * size.height, index));
      signal?.throwIfAborted();
      if (!size || !data) break;
      const { time, duration } = await program.times(index);
      yield { frame: { data: new Uint8ClampedArray(data.buffer), ...size }, index, time, duration };
    }
    await program.finished(index);
  } finally {
    signal?.removeEventListener('abort', abort);
    program.end();
    await bytes.close();
  }
}

/** @param {unknown} path */
function inputOf(path) {
  if (path instanceof URL) return path.protocol === 'file:' ? `file:${fileURLToPath(path)}` : path.href;
  if (typeof path !== 'string' || path === '') throw illegal('data', 'path', path, 'the path of a video file');
  // By its protocol, so that no name is taken for an option or for another protocol.
  return `file:${path}`;
}

/** ffmpeg at work: its pictures come one after the other, what it says of their times beside them. */
class Ffmpeg {
  #child;
  #said = '';
  #rest = '';
  /** @type {{time: number, duration: number}[]} */
  #times = [];
  /** @type {(() => void)[]} */
  #waiting = [];
  /** @type {Promise<number | null>} */
  #over;
  /** @type {NodeJS.ErrnoException | undefined} */
  #failed;
  #silent = false;

  /**
   * @param {string} name
   * @param {string} input
   */
  constructor(name, input) {
    const pictures = ['-map', '0:v:0', '-fps_mode', 'passthrough', '-vf', 'showinfo=checksum=0', '-pix_fmt', 'rgba'];
    const args = [
      '-hide_banner',
      '-nostdin',
      '-nostats',
      '-i',
      input,
      ...pictures,
      '-c:v',
      'pam',
      '-f',
      'image2pipe',
      '-',
    ];
    this.#child = spawn(name, args, { stdio: ['ignore', 'pipe', 'pipe'] });
    this.#over = new Promise((resolve) => {
      this.#child.on('error', (error) => {
        this.#failed = error;
        this.#wake();
        resolve(null);
      });
      this.#child.on('close', resolve);
    });
    this.#child.stderr.setEncoding('utf8').on('data', (text) => this.#hear(text));
    this.#child.stderr.on('close', () => {
      this.#silent = true;
      this.#wake();
    });
  }

  get output() {
    return this.#child.stdout;
  }

  /**
   * When picture `index` is shown. Where nothing says, 25 pictures are shown in a second.
   * @param {number} index
   */
  async times(index) {
    while (index >= this.#times.length && !this.#silent && !this.#failed)
      await new Promise((/** @type {(value: void) => void} */ resolve) => this.#waiting.push(resolve));
    return this.#times[index] ?? { time: index / 25, duration: 1 / 25 };
  }

  /**
   * Looks at how it ended after `count` pictures.
   * @param {number} count
   */
  async finished(count) {
    const code = await this.#over;
    if (this.#failed) throw notStarted(this.#failed, this.#child.spawnfile);
    if (code === 0 && count > 0) return;
    const last = this.#said.trim().split('\n').pop() ?? '';
    throw new TraceCutError(
      count > 0 ? 'truncated' : 'no-video',
      `ffmpeg could not decode the video${count > 0 ? ` after frame ${count - 1}` : ''}: ${last}`,
    );
  }

  end() {
    this.#child.kill('SIGKILL');
  }

  /** @param {string} text */
  #hear(text) {
    const lines = (this.#rest + text).split(/\r\n|\n|\r/);
    this.#rest = lines.pop() ?? '';
    for (const line of lines) {
      const [, time] = /^\[Parsed_showinfo.* n: *\d+ .*pts_time:([-\d.e+]+)/.exec(line) ?? [];
      const [, duration] = / duration_time:([\d.e+-]+)/.exec(line) ?? [];
      if (time !== undefined) this.#times.push({ time: Number(time), duration: Number(duration) || 1 / 25 });
      else if (!line.startsWith('[Parsed_showinfo')) this.#said = `${this.#said}${line}\n`.slice(-WORDS);
    }
    this.#wake();
  }

  #wake() {
    for (const resolve of this.#waiting.splice(0)) resolve();
  }
}

/**
 * @param {NodeJS.ErrnoException} error
 * @param {string} name
 */
function notStarted(error, name) {
  const reason = error.code === 'ENOENT' ? 'it was not found' : error.message;
  return new TraceCutError(
    'unsupported',
    `${name} could not be started: ${reason} (expected ffmpeg to be installed, or its path as the option ffmpeg; ` +
      'without it pass frames, such as those of framesOfY4m or the bytes of PNG or JPEG files)',
    { cause: error },
  );
}

/**
 * The size in the header of a PAM picture; null at the end of the stream.
 * @param {Bytes} bytes
 * @param {number} index
 * @param {number} [maxPixels]
 */
async function pamHeader(bytes, index, maxPixels) {
  const size = { width: 0, height: 0 };
  for (let first = true; ; first = false) {
    const line = await bytes.line(`frame ${index}`);
    if (line === null && first) return null;
    if (line === null || (first && line !== 'P7'))
      throw new TraceCutError('decode', `frame ${index} of ffmpeg is no PAM picture`);
    const [name, value] = line.split(' ');
    if (name === 'WIDTH') size.width = Number(value);
    if (name === 'HEIGHT') size.height = Number(value);
    if (name === 'ENDHDR') return checkedSize(size, maxPixels);
  }
}

/**
 * Looks at a size before memory is taken for it.
 * @template {{width: number, height: number}} T
 * @param {T} size
 * @param {number} [maxPixels]
 * @returns {T}
 */
function checkedSize(size, maxPixels = MAX_PIXELS) {
  wholeNumber('param', 'maxPixels', maxPixels, 1, MOST_PIXELS);
  const width = wholeNumber('frame-size', 'width', size.width, 1, MAX_SIDE);
  const height = wholeNumber('frame-size', 'height', size.height, 1, MAX_SIDE);
  if (width * height > maxPixels) throw tooLarge(width * height, 'pixels in a frame', maxPixels, 'maxPixels');
  return size;
}

/** @param {RawOptions} options */
function rawFormat(options) {
  const {
    width,
    height,
    format,
    frameRate = 25,
    maxPixels,
  } = checkedOptions(options, ['width', 'height', 'format', 'frameRate', 'maxPixels']);
  checkedSize({ width, height }, maxPixels);
  const make = RAW_FORMATS.get(format);
  if (!make) throw illegal('param', 'format', format, [...RAW_FORMATS.keys()].join(', '));
  if (typeof frameRate !== 'number' || !(frameRate > 0 && frameRate <= 1000))
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0 and at most 1000');
  return { ...make(width, height), frameRate };
}

/**
 * @param {import('../worker/frames.js').PixelFrame} frame
 * @param {number} index
 * @param {number} frameRate
 * @returns {DecodedFrame}
 */
function timed(frame, index, frameRate) {
  return { frame, index, time: index / frameRate, duration: 1 / frameRate };
}

/**
 * @param {number} index
 * @param {number} got
 * @param {number} expected
 */
function cutOff(index, got, expected) {
  return new TraceCutError('truncated', `frame ${index} of the stream has ${got} bytes (expected ${expected})`);
}

/** Lines and frames out of pieces of any length. */
class Bytes {
  #pieces;
  /** @type {Uint8Array} */
  #piece = new Uint8Array();
  #place = 0;

  /** @param {ByteSource} source */
  constructor(source) {
    if (typeof source !== 'object' || source === null || !(Symbol.asyncIterator in source || Symbol.iterator in source))
      throw illegal('data', 'source', source, 'a stream of bytes');
    this.#pieces = Symbol.asyncIterator in source ? source[Symbol.asyncIterator]() : source[Symbol.iterator]();
  }

  /** Whether there is more; then some of it is at hand. */
  async #more() {
    while (this.#place >= this.#piece.length) {
      const { value, done } = await this.#pieces.next();
      if (done) return false;
      if (!(value instanceof Uint8Array)) throw illegal('data', 'a piece of the stream', value, 'a Uint8Array');
      [this.#piece, this.#place] = [value, 0];
    }
    return true;
  }

  /**
   * The next line without its end; null at the end of the stream.
   * @param {string} of what it is looked for
   */
  async line(of) {
    const codes = [];
    while (await this.#more()) {
      const code = /** @type {number} */ (this.#piece[this.#place]);
      this.#place += 1;
      if (code === NEWLINE) return String.fromCharCode(...codes).replace(/\r$/, '');
      codes.push(code);
      if (codes.length >= MAX_LINE) break;
    }
    if (codes.length === 0) return null;
    throw new TraceCutError('truncated', `a header line of the stream does not end (${of})`);
  }

  /**
   * So many bytes; null at the end of the stream.
   * @param {number} length
   * @param {number} index of the frame
   */
  async frame(length, index) {
    if (!(await this.#more())) return null;
    // As much memory as there are bytes, whatever the header says.
    let bytes = new Uint8Array(Math.min(length, 2 ** 20));
    let got = 0;
    while (got < length) {
      if (!(await this.#more())) throw cutOff(index, got, length);
      const part = this.#piece.subarray(this.#place, this.#place + length - got);
      if (got + part.length > bytes.length) {
        const before = bytes;
        bytes = new Uint8Array(Math.min(length, 2 * (got + part.length)));
        bytes.set(before.subarray(0, got));
      }
      bytes.set(part, got);
      got += part.length;
      this.#place += part.length;
    }
    return bytes;
  }

  /** What is left is not wanted. */
  async close() {
    await this.#pieces.return?.();
  }
}
