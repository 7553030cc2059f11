// Decodes frames of video files with an installed ffmpeg (5.1 or later).
//
// ffmpeg runs twice. The first run lists the packets of all video tracks without decoding them, which gives the track, the
// duration of the last picture and the expected times of the pictures. The second decodes that track: pixels arrive on
// standard output, the time and size of each picture on standard error. The command line does the same.

import { open } from 'node:fs/promises';
import { basename } from 'node:path';
import { fileURLToPath } from 'node:url';
import { TraceCutError, checkOptions, illegal } from '../check/errors.js';
import { type Damage, MIN_FRAMES } from '../video/reader.js';
import {
  chooseTrack,
  countPictures,
  DECODE,
  FaultFinder,
  Ffmpeg,
  LIST,
  LogReader,
  type Message,
  readTracks,
  type ShownPicture,
  type Track,
  WRITE,
} from './ffmpeg.js';
import { ByteReader, type FileFrame, RGB24, checkSize, toRgba } from './raw.js';
import type { PixelFrame } from '../worker/frames.js';

/** Options of calling ffmpeg. */
export interface FfmpegOptions {
  /** Path of the program; `'ffmpeg'` from the PATH if not given. */
  ffmpeg?: string;
  signal?: AbortSignal;
  /** As for {@link RawOptions}. */
  maxPixels?: number;
  /**
   * Called if a file is cut off or damaged; the frames then end before the damage. Without it, or if there are fewer than
   * two frames before the damage, that is an error (`truncated`).
   */
  onDamage?: (damage: Damage) => void;
}

/** A file: ffmpeg's input argument, and its name for errors. */
type VideoInput = { input: string; name: string };

/**
 * Reads the frames of a video file (MP4, MOV, WebM, …) with ffmpeg (5.1 or later), which must be installed (error
 * `unsupported` otherwise). Each picture of the file is yielded once, upright, with square pixels and its own time;
 * docs/frames.md defines the pictures of a file. A file that is damaged or cut off yields the frames before the damage,
 * then error `truncated`. Leaving the loop stops ffmpeg. The file is read twice, so it cannot be a pipe.
 *
 * ```js
 * const result = await segmentVideo(framesOfVideo('clip.mp4'), { size: 480 }).collect();
 * ```
 */
export async function* framesOfVideo(
  path: string | URL,
  options: FfmpegOptions = {},
): AsyncGenerator<FileFrame, void, undefined> {
  const legal = ['ffmpeg', 'signal', 'maxPixels', 'onDamage'];
  const { onDamage, ...runOptions } = checkOptions(options, legal);
  const file = toVideoInput(path);
  runOptions.signal?.throwIfAborted();
  const video = await selectTrack(file, runOptions);
  const timeline = new Timeline();
  let isDamaged = false;
  const pictures = decodePictures(file, video, runOptions);
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
  const frames = timeline.numFrames;
  const message = `${file.name} is cut off or damaged after ${frames} whole ${frames === 1 ? 'frame' : 'frames'}`;
  const error = new TraceCutError('truncated', message, { frames });
  if (!onDamage || frames < MIN_FRAMES) throw error;
  onDamage({ frames, total: null, error });
}

function toVideoInput(path: unknown) {
  if (path instanceof URL && path.protocol !== 'file:') return { input: path.href, name: path.href };
  const name = path instanceof URL ? fileURLToPath(path) : path;
  if (typeof name !== 'string' || name === '') throw illegal('data', 'path', path, 'the path of a video file');
  // With its protocol, so that no name is mistaken for an option or another protocol.
  return { input: `file:${name}`, name: basename(name) };
}

type FfmpegRunOptions = Pick<FfmpegOptions, 'ffmpeg' | 'signal' | 'maxPixels'>;

/** A track and ffmpeg's name of its file's format. */
type SelectedTrack = { track: Track; demuxer: string };

async function selectTrack(
  { input, name }: VideoInput,
  { ffmpeg = 'ffmpeg', signal }: FfmpegRunOptions,
): Promise<SelectedTrack> {
  const run = new Ffmpeg({ program: ffmpeg, input, after: LIST, signal });
  const [{ demuxer, defaults, isMissing }, tracks] = await Promise.all([readOpening(run), readTracks(run.output)]);
  const track = chooseTrack(tracks, defaults);
  const start = await readEnd(input, 'first');
  const animation = detectAnimation(start);
  if (demuxer && track && !(animation && countPictures(track) < 2)) return { demuxer, track };
  if (isMissing) throw new TraceCutError('no-video', `${name} is missing: there is no such file`);
  if (animation)
    throw new TraceCutError('unsupported', `${name} is an animated ${animation}, which this ffmpeg cannot read`);
  if (start === '') throw new TraceCutError('no-video', `${name} is empty`);
  if (!demuxer) throw createNoVideoError(name, start);
  if (defaults.length === 0) throw new TraceCutError('no-video', `${name} has no video track`);
  if (tracks.length > 0) throw new TraceCutError('no-video', `${name} holds no picture (it may be cut off)`);
  throw new TraceCutError('codec', `${name} has a video track of a kind that this ffmpeg cannot read`);
}

/** Demuxers that make pictures of text. */
const TEXT_DEMUXERS = ['tty', 'bin', 'xbin', 'adf', 'idf'];

/**
 * Parses ffmpeg's description of a file: its format, null if it cannot be read; and for each video track that is no
 * attached picture, if it is a default track.
 */
async function readOpening(run: Ffmpeg) {
  let demuxer: string | null = null;
  let isInput = false;
  let isMissing = false;
  const defaults: boolean[] = [];
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

function createNoVideoError(name: string, start: string) {
  if (!start.startsWith('ftyp', 4))
    return new TraceCutError('no-video', `${name} is not a video, or one that this ffmpeg cannot read`);
  const reason = 'the index, which MP4 files may have at their end, is missing';
  return new TraceCutError('truncated', `${name} is cut off: ${reason}`, { frames: 0 });
}

/** Returns the format of an animated image that not every ffmpeg reads; null for other files. */
function detectAnimation(start: string) {
  // RIFF, WEBP, VP8X and its flags, of which bit 1 marks an animation.
  if (/^RIFF....WEBPVP8X/s.test(start) && start.charCodeAt(20) & 2) return 'WebP';
  return start.startsWith('ftypavis', 4) ? 'AVIF' : null;
}

/** Number of bytes inspected at both ends of a file. */
const END_BYTES = 32;

/** Returns the first or the last bytes of a file as characters, none if it cannot be opened. */
async function readEnd(input: string, end: 'first' | 'last') {
  const file = await open(input.replace(/^file:/, '')).catch(() => null);
  if (!file) return '';
  try {
    const from = end === 'first' ? 0 : Math.max(0, (await file.stat()).size - END_BYTES);
    const { buffer, bytesRead } = await file.read(new Uint8Array(END_BYTES), 0, END_BYTES, from);
    return String.fromCharCode(...buffer.subarray(0, bytesRead));
  } finally {
    await file.close();
  }
}

/** Returns true if a GIF lacks its last byte, a semicolon, which ffmpeg 5 does not report. Padding may follow it. */
async function isCutGif(input: string) {
  const end = await readEnd(input, 'last');
  return end !== '' && !/;[\0\r\n]*$/.test(end);
}

/**
 * Yields the pictures of a track until the first damaged one.
 * @returns true if the file is damaged or cut off
 */
async function* decodePictures(
  file: VideoInput,
  { track, demuxer }: SelectedTrack,
  { ffmpeg = 'ffmpeg', signal, maxPixels }: FfmpegRunOptions,
): AsyncGenerator<Picture, boolean, undefined> {
  const after = ['-map', `0:V:${track.position}`, ...WRITE];
  const run = new Ffmpeg({ program: ffmpeg, input: file.input, before: DECODE, after, signal });
  const [log, faults, pixels] = [new LogReader(demuxer), new FaultFinder(track, demuxer), new ByteReader(run.output)];
  const kinds = new Set<Message['kind']>();
  let numGiven = 0;
  // If the first picture is faulty or missing, later ones may depend on it, up to the next key picture.
  let waitsForKey = false;
  try {
    for await (const message of parseLog(run, log)) {
      faults.take(message);
      kinds.add(message.kind);
      if (message.kind === 'decoding-failed' && numGiven === 0) waitsForKey = true;
      if (message.kind !== 'shown') continue;
      const frame = await readPicture(pixels, message, maxPixels);
      if (!frame) break;
      if (faults.isWhole(message) && (message.isKey || !waitsForKey)) {
        faults.record(message);
        waitsForKey = false;
        numGiven += 1;
        yield { frame, time: message.time, duration: faults.getDuration(message.time) };
      } else if (numGiven > 0) return true;
      else waitsForKey = true;
    }
    await pixels.close();
    const hasSucceeded = (await run.ended) === 0;
    signal?.throwIfAborted();
    if (numGiven === 0) throw createNoPictureError(file.name, track.codec, kinds);
    if (demuxer === 'gif' && (await isCutGif(file.input))) return true;
    return !faults.isWholeAtEnd() || (!hasSucceeded && numGiven < countPictures(track));
  } finally {
    run.kill();
    await pixels.close();
    await run.ended;
  }
}

async function* parseLog(run: Ffmpeg, log: LogReader) {
  for await (const line of run.lines()) yield* log.readLine(line);
}

/** Reads the next picture of standard output; null if the output ends before it is whole. */
async function readPicture(pixels: ByteReader, { width, height }: ShownPicture, maxPixels?: number) {
  checkSize(width, height, maxPixels);
  const bytes = await pixels.read(3 * width * height);
  return bytes?.length === 3 * width * height ? { data: toRgba(bytes, RGB24), width, height } : null;
}

function createNoPictureError(name: string, codec: string, kinds: Set<Message['kind']>) {
  if (kinds.has('unknown-option'))
    return new TraceCutError('unsupported', 'this ffmpeg is too old (expected 5.1 or later)');
  const message = kinds.has('no-decoder')
    ? `${name}: this ffmpeg has no decoder for its video (${codec})`
    : `${name}: none of its pictures can be decoded: they are damaged, or this ffmpeg cannot read their kind (${codec})`;
  return new TraceCutError('codec', message);
}

/** Duration of a picture if its file does not say, in seconds. */
const DEFAULT_DURATION_S = 1 / 25;

/** A decoded picture, with its time and duration from the file in seconds, null if the file does not say. */
export type Picture = { frame: PixelFrame; time: number | null; duration: number | null };

/** Assigns times to the pictures of a file, as docs/frames.md defines. Each picture is kept until the next one is known. */
export class Timeline {
  #pending: Picture | null = null;
  #last: { time: number; duration: number } | null = null;
  /** Number of frames returned so far. */
  numFrames = 0;

  /** Takes the next picture, null after the last, and returns the frame before it, null if there is none. */
  take(next: Picture | null): FileFrame | null {
    const picture = this.#pending;
    this.#pending = next;
    if (!picture || isBeforeStart(picture, next)) return null;
    this.#last = this.#computeTime(picture, next);
    this.numFrames += 1;
    return { frame: picture.frame, index: this.numFrames - 1, ...this.#last };
  }

  #computeTime(picture: Picture, next: Picture | null) {
    const last = this.#last;
    const following = last ? last.time + last.duration : 0;
    const time = picture.time !== null && picture.time > (last?.time ?? -Infinity) ? picture.time : following;
    const ownDuration = picture.duration || last?.duration || DEFAULT_DURATION_S;
    const isFollowed = next !== null && next.time !== null && next.time > time;
    return { time, duration: isFollowed ? Number(next.time) - time : ownDuration };
  }
}

/** Returns true if a picture ends at or before zero, where players begin. */
function isBeforeStart({ time, duration }: Picture, next: Picture | null) {
  if (time === null || time >= 0) return false;
  const end = next ? next.time : time + (duration ?? 0);
  return end !== null && end <= 0;
}
