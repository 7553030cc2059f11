// Frames of video files, decoded by an installed ffmpeg (5.1 or later).
//
// ffmpeg runs twice. The first run lists the packets of all video tracks without decoding them, which tells the track, the
// duration of the last picture and the times that pictures must have. The second decodes that track: pixels come on
// standard output, the time and size of each picture on standard error. The command line does the same.

import { open } from 'node:fs/promises';
import { basename } from 'node:path';
import { fileURLToPath } from 'node:url';
import { checkedOptions, illegal, TraceCutError } from '../check/errors.js';
import { FEWEST } from '../video/reader.js';
import { FaultFinder } from './faults.js';
import { DECODE, Ffmpeg, LIST, WRITE } from './ffmpeg.js';
import { chooseTrack, numPicturesOf, readTracks } from './listing.js';
import { LogReader } from './log.js';
import { ByteReader, checkSize, RGB24, toRgba } from './raw.js';

/** @typedef {import('./raw.js').FileFrame} FileFrame */

/**
 * How ffmpeg is called.
 * @typedef {object} FfmpegOptions
 * @property {string} [ffmpeg] the program; `'ffmpeg'` from the PATH if not given
 * @property {AbortSignal} [signal] ends it
 * @property {number} [maxPixels] as of {@link RawOptions}
 * @property {(damage: import('../video/reader.js').Damage) => void} [onDamage] with it, a file that is cut off or damaged
 *   ends before the damage, which this is told of; without it, and where fewer than two frames come before, that is an error
 *   (`truncated`)
 */

/** A file: as ffmpeg takes it, and its name for errors. @typedef {{input: string, name: string}} VideoFile */

/**
 * Reads the frames of a video file (MP4, MOV, WebM, …) by ffmpeg (5.1 or later), which has to be installed: without it,
 * error `unsupported`. Each picture of the file comes once, upright, with square pixels and with its own time;
 * docs/frames.md says what the pictures of a file are. A file that is damaged or cut off gives the frames before that, then
 * error `truncated`. Leaving the loop ends ffmpeg. The file is read twice, so it may be no pipe.
 *
 * ```js
 * const result = await segmentVideo(framesOfVideo('clip.mp4'), { size: 480 }).collect();
 * ```
 * @param {string | URL} path
 * @param {FfmpegOptions} [options]
 * @returns {AsyncGenerator<FileFrame, void, undefined>}
 */
export async function* framesOfVideo(path, options = {}) {
  const legal = ['ffmpeg', 'signal', 'maxPixels', 'onDamage'];
  const { onDamage, ...given } = checkedOptions(options, legal);
  const file = toFile(path);
  given.signal?.throwIfAborted();
  const video = await findVideo(file, given);
  const timeline = new Timeline();
  let isDamaged = false;
  const pictures = decodePictures(file, video, given);
  try {
    for (;;) {
      const { value, done } = await pictures.next();
      const frame = timeline.take(done ? null : value);
      if (frame) yield frame;
      if (done) {
        isDamaged = value;
        break;
      }
    }
  } finally {
    await pictures.return(false);
  }
  if (!isDamaged) return;
  const frames = timeline.numGiven;
  const words = `${file.name} is cut off or damaged after ${frames} whole ${frames === 1 ? 'frame' : 'frames'}`;
  const error = new TraceCutError('truncated', words, { frames });
  if (!onDamage || frames < FEWEST) throw error;
  onDamage({ frames, total: null, error });
}

/** @param {unknown} path */
function toFile(path) {
  if (path instanceof URL && path.protocol !== 'file:') return { input: path.href, name: path.href };
  const name = path instanceof URL ? fileURLToPath(path) : path;
  if (typeof name !== 'string' || name === '') throw illegal('data', 'path', path, 'the path of a video file');
  // By its protocol, so that no name is taken for an option or for another protocol.
  return { input: `file:${name}`, name: basename(name) };
}

/** @typedef {Pick<FfmpegOptions, 'ffmpeg' | 'signal' | 'maxPixels'>} RunOptions */

/** A track and the format of its file, as ffmpeg calls it. @typedef {{track: Track, demuxer: string}} Video */

/** @typedef {import('./listing.js').Track} Track */

/**
 * @param {VideoFile} file
 * @param {RunOptions} options
 * @returns {Promise<Video>}
 */
async function findVideo({ input, name }, { ffmpeg = 'ffmpeg', signal }) {
  const run = new Ffmpeg({ program: ffmpeg, input, after: LIST, signal });
  const [{ demuxer, defaults, isMissing }, tracks] = await Promise.all([readOpening(run), readTracks(run.output)]);
  const track = chooseTrack(tracks, defaults);
  const start = await bytesOf(input, 'first');
  const animation = animatedFormat(start);
  if (demuxer && track && !(animation && numPicturesOf(track) < 2)) return { demuxer, track };
  if (isMissing) throw new TraceCutError('no-video', `${name} is missing: there is no such file`);
  if (animation)
    throw new TraceCutError('unsupported', `${name} is an animated ${animation}, which this ffmpeg cannot read`);
  if (start === '') throw new TraceCutError('no-video', `${name} is empty`);
  if (!demuxer) throw withoutVideo(name, start);
  if (defaults.length === 0) throw new TraceCutError('no-video', `${name} has no video track`);
  if (tracks.length > 0) throw new TraceCutError('no-video', `${name} holds no picture (it may be cut off)`);
  throw new TraceCutError('codec', `${name} has a video track of a kind that this ffmpeg cannot read`);
}

/** What ffmpeg calls those that make pictures of text. */
const TEXT_DEMUXERS = ['tty', 'bin', 'xbin', 'adf', 'idf'];

/**
 * Reads what ffmpeg says of a file when it opens it: the format, null if it cannot be read; for each video track that is no
 * attached picture, whether it is a default one.
 * @param {Ffmpeg} run
 */
async function readOpening(run) {
  /** @type {string | null} */
  let demuxer = null;
  let isInput = false;
  let isMissing = false;
  /** @type {boolean[]} */
  const defaults = [];
  for await (const line of run.lines()) {
    const format = /^\[info\] Input #0, (.*?), from /.exec(line)?.[1];
    if (format) isInput = !TEXT_DEMUXERS.includes(format);
    if (format && isInput) demuxer = format;
    if (line.startsWith('[info] Output #0')) isInput = false;
    const isVideo = isInput && /^\[info\] +Stream #0:.*: Video: /.test(line);
    if (isVideo && !line.includes('(attached pic)')) defaults.push(line.includes('(default)'));
    isMissing ||= line.includes(': No such file or directory');
  }
  return { demuxer, defaults, isMissing };
}

/**
 * @param {string} name
 * @param {string} start
 */
function withoutVideo(name, start) {
  if (!start.startsWith('ftyp', 4))
    return new TraceCutError('no-video', `${name} is not a video, or one that this ffmpeg cannot read`);
  const words = 'the index, which MP4 files may have at their end, is missing';
  return new TraceCutError('truncated', `${name} is cut off: ${words}`, { frames: 0 });
}

/**
 * Names the format of an animated image that not every ffmpeg reads; null for other files.
 * @param {string} start
 */
function animatedFormat(start) {
  // RIFF, WEBP, VP8X and its flags, of which bit 1 says that it is animated.
  if (/^RIFF....WEBPVP8X/s.test(start) && start.charCodeAt(20) & 2) return 'WebP';
  return start.startsWith('ftypavis', 4) ? 'AVIF' : null;
}

/** Number of bytes that are looked at, at both ends of a file. */
const END_BYTES = 32;

/**
 * Returns the first or the last bytes of a file as characters, none where it cannot be opened.
 * @param {string} input
 * @param {'first' | 'last'} which
 */
async function bytesOf(input, which) {
  const file = await open(input.replace(/^file:/, '')).catch(() => null);
  if (!file) return '';
  try {
    const from = which === 'first' ? 0 : Math.max(0, (await file.stat()).size - END_BYTES);
    const { buffer, bytesRead } = await file.read(new Uint8Array(END_BYTES), 0, END_BYTES, from);
    return String.fromCharCode(...buffer.subarray(0, bytesRead));
  } finally {
    await file.close();
  }
}

/**
 * Returns true if a GIF lacks its last byte, a semicolon, which ffmpeg 5 does not miss. Padding may follow it.
 * @param {string} input
 */
async function isCutGif(input) {
  const end = await bytesOf(input, 'last');
  return end !== '' && !/;[\0\r\n]*$/.test(end);
}

/**
 * Gives the pictures of a track until the first damaged one.
 * @param {VideoFile} file
 * @param {Video} video
 * @param {RunOptions} options
 * @returns {AsyncGenerator<Picture, boolean, undefined>} true if the file is damaged or cut off
 */
async function* decodePictures(file, { track, demuxer }, { ffmpeg = 'ffmpeg', signal, maxPixels }) {
  const after = ['-map', `0:V:${track.position}`, ...WRITE];
  const run = new Ffmpeg({ program: ffmpeg, input: file.input, before: DECODE, after, signal });
  const [log, faults, pixels] = [new LogReader(demuxer), new FaultFinder(track, demuxer), new ByteReader(run.output)];
  const kinds = new Set();
  let numGiven = 0;
  // Pictures after a first one that is faulty or missing may be made of it, up to the next key picture.
  let waitsForKey = false;
  try {
    for await (const message of messagesOf(run, log)) {
      faults.take(message);
      kinds.add(message.kind);
      if (message.kind === 'decoding-failed' && numGiven === 0) waitsForKey = true;
      if (message.kind !== 'shown') continue;
      const frame = await readPicture(pixels, message, maxPixels);
      if (!frame) break;
      if (faults.isWhole(message) && (message.isKey || !waitsForKey)) {
        faults.give(message);
        waitsForKey = false;
        numGiven += 1;
        yield { frame, time: message.time, duration: faults.durationAt(message.time) };
      } else if (numGiven > 0) return true;
      else waitsForKey = true;
    }
    await pixels.close();
    const hasSucceeded = (await run.ended) === 0;
    signal?.throwIfAborted();
    if (numGiven === 0) throw withoutPicture(file.name, track.codec, kinds);
    if (demuxer === 'gif' && (await isCutGif(file.input))) return true;
    return !faults.isWholeAtEnd() || (!hasSucceeded && numGiven < numPicturesOf(track));
  } finally {
    run.end();
    await pixels.close();
  }
}

/**
 * @param {Ffmpeg} run
 * @param {LogReader} log
 */
async function* messagesOf(run, log) {
  for await (const line of run.lines()) yield* log.readLine(line);
}

/**
 * Reads the next picture of standard output; null where that ends before it is whole.
 * @param {ByteReader} pixels
 * @param {import('./log.js').Shown} shown
 * @param {number} [maxPixels]
 */
async function readPicture(pixels, { width, height }, maxPixels) {
  checkSize(width, height, maxPixels);
  const bytes = await pixels.read(3 * width * height);
  return bytes?.length === 3 * width * height ? { data: toRgba(bytes, RGB24), width, height } : null;
}

/**
 * @param {string} name
 * @param {string} codec
 * @param {Set<import('./log.js').Message['kind']>} kinds of messages
 */
function withoutPicture(name, codec, kinds) {
  if (kinds.has('unknown-option'))
    return new TraceCutError('unsupported', 'this ffmpeg is too old (expected 5.1 or later)');
  const words = kinds.has('no-decoder')
    ? `${name}: this ffmpeg has no decoder for its video (${codec})`
    : `${name}: none of its pictures can be decoded: they are damaged, or this ffmpeg cannot read their kind (${codec})`;
  return new TraceCutError('codec', words);
}

/** Seconds that a picture is shown where its file does not say. */
const DEFAULT_DURATION_S = 1 / 25;

/**
 * A decoded picture, with what its file says of its time in seconds, null where it says nothing.
 * @typedef {{frame: import('../worker/frames.js').PixelFrame, time: number | null, duration: number | null}} Picture
 */

/** Gives the pictures of a file their times, as docs/frames.md tells. Each is held until the next one is there. */
export class Timeline {
  /** @type {Picture | null} */
  #held = null;
  /** @type {{time: number, duration: number} | null} */
  #last = null;
  /** Number of frames given so far. */
  numGiven = 0;

  /**
   * Takes the next picture, null after the last, and gives the frame before it; null where there is none.
   * @param {Picture | null} next
   * @returns {FileFrame | null}
   */
  take(next) {
    const picture = this.#held;
    this.#held = next;
    if (!picture || isBeforeStart(picture, next)) return null;
    this.#last = this.#timeOf(picture, next);
    this.numGiven += 1;
    return { frame: picture.frame, index: this.numGiven - 1, ...this.#last };
  }

  /**
   * @param {Picture} picture
   * @param {Picture | null} next
   */
  #timeOf(picture, next) {
    const last = this.#last;
    const following = last ? last.time + last.duration : 0;
    const time = picture.time !== null && picture.time > (last?.time ?? -Infinity) ? picture.time : following;
    const known = picture.duration || last?.duration || DEFAULT_DURATION_S;
    const isFollowed = next !== null && next.time !== null && next.time > time;
    return { time, duration: isFollowed ? Number(next.time) - time : known };
  }
}

/**
 * Returns true if a picture ends at or before zero, where players begin.
 * @param {Picture} picture
 * @param {Picture | null} next
 */
function isBeforeStart({ time, duration }, next) {
  if (time === null || time >= 0) return false;
  const end = next ? next.time : time + (duration ?? 0);
  return end !== null && end <= 0;
}
