// Frames of video files, decoded by an installed ffmpeg (5.1 or later).
//
// ffmpeg runs twice. The first run lists the packets of all video tracks without decoding them, which tells the track, the
// duration of the last picture and the times that pictures must have. The second decodes that track: pixels come on
// standard output, the time and size of each picture on standard error. The command line does the same.

import { open } from 'node:fs/promises';
import { basename } from 'node:path';
import { fileURLToPath } from 'node:url';
import { checkedOptions, illegal, TraceCutError } from '../check/errors.js';
import { type Damage, FEWEST } from '../video/reader.js';
import { FaultFinder } from './faults.js';
import { DECODE, Ffmpeg, LIST, WRITE } from './ffmpeg.js';
import { type Track, chooseTrack, numPicturesOf, readTracks } from './listing.js';
import { LogReader, type Message, type Shown } from './log.js';
import { ByteReader, type FileFrame, RGB24, checkSize, toRgba } from './raw.js';
import type { PixelFrame } from '../worker/frames.js';

/** How ffmpeg is called. */
export interface FfmpegOptions {
  /** The program; `'ffmpeg'` from the PATH if not given. */
  ffmpeg?: string;
  signal?: AbortSignal;
  /** As of {@link RawOptions}. */
  maxPixels?: number;
  /**
   * With it, a file that is cut off or damaged ends before the damage, which this is told of; without it, and where
   * fewer than two frames come before, that is an error (`truncated`).
   */
  onDamage?: (damage: Damage) => void;
}

/** A file: as ffmpeg takes it, and its name for errors. */
export type VideoFile = { input: string; name: string };

/**
 * Reads the frames of a video file (MP4, MOV, WebM, …) by ffmpeg (5.1 or later), which has to be installed: without it,
 * error `unsupported`. Each picture of the file comes once, upright, with square pixels and with its own time;
 * docs/frames.md says what the pictures of a file are. A file that is damaged or cut off gives the frames before that, then
 * error `truncated`. Leaving the loop ends ffmpeg. The file is read twice, so it may be no pipe.
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

function toFile(path: unknown) {
  if (path instanceof URL && path.protocol !== 'file:') return { input: path.href, name: path.href };
  const name = path instanceof URL ? fileURLToPath(path) : path;
  if (typeof name !== 'string' || name === '') throw illegal('data', 'path', path, 'the path of a video file');
  // By its protocol, so that no name is taken for an option or for another protocol.
  return { input: `file:${name}`, name: basename(name) };
}

export type RunOptions = Pick<FfmpegOptions, 'ffmpeg' | 'signal' | 'maxPixels'>;

/** A track and the format of its file, as ffmpeg calls it. */
export type Video = { track: Track; demuxer: string };

async function findVideo({ input, name }: VideoFile, { ffmpeg = 'ffmpeg', signal }: RunOptions): Promise<Video> {
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

function withoutVideo(name: string, start: string) {
  if (!start.startsWith('ftyp', 4))
    return new TraceCutError('no-video', `${name} is not a video, or one that this ffmpeg cannot read`);
  const words = 'the index, which MP4 files may have at their end, is missing';
  return new TraceCutError('truncated', `${name} is cut off: ${words}`, { frames: 0 });
}

/** Names the format of an animated image that not every ffmpeg reads; null for other files. */
function animatedFormat(start: string) {
  // RIFF, WEBP, VP8X and its flags, of which bit 1 says that it is animated.
  if (/^RIFF....WEBPVP8X/s.test(start) && start.charCodeAt(20) & 2) return 'WebP';
  return start.startsWith('ftypavis', 4) ? 'AVIF' : null;
}

/** Number of bytes that are looked at, at both ends of a file. */
const END_BYTES = 32;

/** Returns the first or the last bytes of a file as characters, none where it cannot be opened. */
async function bytesOf(input: string, which: 'first' | 'last') {
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

/** Returns true if a GIF lacks its last byte, a semicolon, which ffmpeg 5 does not miss. Padding may follow it. */
async function isCutGif(input: string) {
  const end = await bytesOf(input, 'last');
  return end !== '' && !/;[\0\r\n]*$/.test(end);
}

/**
 * Gives the pictures of a track until the first damaged one.
 * @returns true if the file is damaged or cut off
 */
async function* decodePictures(
  file: VideoFile,
  { track, demuxer }: Video,
  { ffmpeg = 'ffmpeg', signal, maxPixels }: RunOptions,
): AsyncGenerator<Picture, boolean, undefined> {
  const after = ['-map', `0:V:${track.position}`, ...WRITE];
  const run = new Ffmpeg({ program: ffmpeg, input: file.input, before: DECODE, after, signal });
  const [log, faults, pixels] = [new LogReader(demuxer), new FaultFinder(track, demuxer), new ByteReader(run.output)];
  const kinds = new Set<Message['kind']>();
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

async function* messagesOf(run: Ffmpeg, log: LogReader) {
  for await (const line of run.lines()) yield* log.readLine(line);
}

/** Reads the next picture of standard output; null where that ends before it is whole. */
async function readPicture(pixels: ByteReader, { width, height }: Shown, maxPixels?: number) {
  checkSize(width, height, maxPixels);
  const bytes = await pixels.read(3 * width * height);
  return bytes?.length === 3 * width * height ? { data: toRgba(bytes, RGB24), width, height } : null;
}

function withoutPicture(name: string, codec: string, kinds: Set<Message['kind']>) {
  if (kinds.has('unknown-option'))
    return new TraceCutError('unsupported', 'this ffmpeg is too old (expected 5.1 or later)');
  const words = kinds.has('no-decoder')
    ? `${name}: this ffmpeg has no decoder for its video (${codec})`
    : `${name}: none of its pictures can be decoded: they are damaged, or this ffmpeg cannot read their kind (${codec})`;
  return new TraceCutError('codec', words);
}

/** Seconds that a picture is shown where its file does not say. */
const DEFAULT_DURATION_S = 1 / 25;

/** A decoded picture, with what its file says of its time in seconds, null where it says nothing. */
export type Picture = { frame: PixelFrame; time: number | null; duration: number | null };

/** Gives the pictures of a file their times, as docs/frames.md tells. Each is held until the next one is there. */
export class Timeline {
  #held: Picture | null = null;
  #last: { time: number; duration: number } | null = null;
  /** Number of frames given so far. */
  numGiven = 0;

  /** Takes the next picture, null after the last, and gives the frame before it; null where there is none. */
  take(next: Picture | null): FileFrame | null {
    const picture = this.#held;
    this.#held = next;
    if (!picture || isBeforeStart(picture, next)) return null;
    this.#last = this.#timeOf(picture, next);
    this.numGiven += 1;
    return { frame: picture.frame, index: this.numGiven - 1, ...this.#last };
  }

  #timeOf(picture: Picture, next: Picture | null) {
    const last = this.#last;
    const following = last ? last.time + last.duration : 0;
    const time = picture.time !== null && picture.time > (last?.time ?? -Infinity) ? picture.time : following;
    const known = picture.duration || last?.duration || DEFAULT_DURATION_S;
    const isFollowed = next !== null && next.time !== null && next.time > time;
    return { time, duration: isFollowed ? Number(next.time) - time : known };
  }
}

/** Returns true if a picture ends at or before zero, where players begin. */
function isBeforeStart({ time, duration }: Picture, next: Picture | null) {
  if (time === null || time >= 0) return false;
  const end = next ? next.time : time + (duration ?? 0);
  return end !== null && end <= 0;
}
