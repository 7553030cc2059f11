// An installed ffmpeg: its arguments, output and exit, and what it prints while it decodes: its log (`-loglevel level+info -debug_ts`,
// filter `showinfo`) and its list of a file's packets (`-f framecrc`). From both follows where a file is damaged: the first decoded
// picture that must not be yielded.
//
// The command line has the same arguments, which a test compares, and reads the same output (`cli/src/ffmpeg.rs`, `cli/src/ffmpeg/`).
// Checked with ffmpeg 5.1 and 9. Its threads write at once: one may begin a message on another's line, but the words searched for
// here are never split.

import { spawn } from 'node:child_process';
import { TraceCutError } from '../check/errors.js';

/** Before the input, in both runs: each message with its level; times as in the file, without an offset. */
export const GENERAL = ['-hide_banner', '-nostdin', '-nostats', '-loglevel', 'level+info', '-copyts'];

/** After the input, in the first run: a line for each packet of each video track that is no attached picture. */
export const LIST = ['-map', '0:V', '-c', 'copy', '-copyinkf', '-f', 'framecrc'];

/**
 * Before the input, in the second run: a message for each packet read and each picture decoded; one thread, as ffmpeg 5.1
 * with several sometimes fails to report a faulty picture; one filter chain for all pictures, so that later ones are
 * scaled to the size of the first.
 */
export const DECODE = ['-debug_ts', '-threads', '1', '-reinit_filter', '0'];

/**
 * Square pixels, never fewer of them; the same RGB bytes from every version; a message for each picture; last, increasing
 * times, which the muxer requires.
 */
export const FILTERS =
  "scale=w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))':" +
  'flags=bicubic+accurate_rnd+full_chroma_int+bitexact,' +
  'setsar=1,format=rgb24,showinfo=checksum=0,settb=1/25,setpts=N';

/** After the input and the track, in the second run: each picture once, as RGB bytes. */
export const WRITE = ['-fps_mode', 'passthrough', '-vf', FILTERS, '-f', 'rawvideo'];

/** A run of ffmpeg: bytes on `output`, and messages line by line. */
export class Ffmpeg {
  #child;
  #signal;
  #failure: NodeJS.ErrnoException | undefined;
  #rest = '';
  #lines: string[] = [];
  #isLogClosed = false;
  #wake: () => void = () => {};

  /** Resolves to the exit code, null if it was killed. */
  ended: Promise<number | null>;

  /** @param options the arguments before and after the input, in addition to the general ones */
  constructor({
    program,
    input,
    before = [],
    after,
    signal,
  }: {
    program: string;
    input: string;
    before?: readonly string[];
    after: readonly string[];
    signal?: AbortSignal;
  }) {
    const { AV_LOG_FORCE_COLOR: _, ...env } = process.env;
    this.#signal = signal;
    this.#child = spawn(program, [...GENERAL, ...before, '-i', input, ...after, '-'], {
      stdio: ['ignore', 'pipe', 'pipe'],
      env: { ...env, AV_LOG_FORCE_NOCOLOR: '1' },
      signal,
      killSignal: 'SIGKILL',
    });
    this.#child.on('error', (error) => (this.#failure = error));
    // All is read at once: ffmpeg never waits for a reader of its messages.
    this.#child.stderr.setEncoding('utf8').on('data', (text) => this.#addText(text));
    this.#child.stderr.on('close', () => {
      this.#isLogClosed = true;
      this.#wake();
    });
    this.ended = new Promise((resolve) => this.#child.on('close', resolve));
  }

  get output() {
    return this.#child.stdout;
  }

  /**
   * Yields the lines that it writes to standard error.
   * @throws the signal's reason, or error `unsupported` if ffmpeg could not be started
   */
  async *lines() {
    for (;;) {
      const line = this.#lines.shift();
      if (line !== undefined) yield line;
      else if (this.#isLogClosed) break;
      else await new Promise((resolve: (value: void) => void) => (this.#wake = resolve));
    }
    this.#signal?.throwIfAborted();
    if (this.#failure) throw createStartError(this.#failure, this.#child.spawnfile);
  }

  kill() {
    this.#child.kill('SIGKILL');
  }

  #addText(text: string) {
    const lines = (this.#rest + text).split('\n');
    this.#rest = lines.pop() ?? '';
    this.#lines.push(...lines);
    this.#wake();
  }
}

function createStartError(error: NodeJS.ErrnoException, name: string) {
  const reason = error.code === 'ENOENT' ? 'it was not found' : error.message;
  const message =
    `${name} could not be started: ${reason} (expected ffmpeg 5.1 or later on the PATH, from https://ffmpeg.org/download.html ` +
    "or a package manager, or its path: framesOfVideo(file, { ffmpeg: '/path/of/ffmpeg' }) of tracecut/node; without it " +
    'pass frames, such as the bytes of PNG or JPEG files)';
  return new TraceCutError('unsupported', message, { cause: error });
}

/** A unit of time in seconds, as a fraction. */
export type TimeBase = { numerator: number; denominator: number };

export const toSeconds = (ticks: number, { numerator, denominator }: TimeBase) => (ticks * numerator) / denominator;

/**
 * A filtered picture, next on standard output: its number, its time in seconds (null if the file has none) and its size
 * in pixels.
 */
export type ShownPicture = {
  kind: 'shown';
  index: number;
  time: number | null;
  width: number;
  height: number;
  isKey: boolean;
};

/**
 * A message about the pictures. `reading-failed` concerns the file, and `isEnd` says that it ended too early;
 * `decoding-failed` concerns a packet; `faulty` precedes the `decoded` of the same picture.
 */
export type Message =
  | ShownPicture
  | { kind: 'packet-read' | 'decoding-failed' | 'faulty' | 'decoded' | 'no-decoder' | 'unknown-option' }
  | { kind: 'reading-failed'; isEnd: boolean };

/** Texts that identify messages. */
const MESSAGES: [text: string, message: Message][] = [
  ['demuxer -> ', { kind: 'packet-read' }],
  ['decoder -> ', { kind: 'decoded' }],
  ['corrupt decoded frame', { kind: 'faulty' }],
  ['Error while decoding stream', { kind: 'decoding-failed' }],
  ['Decoding error:', { kind: 'decoding-failed' }],
  ['Error submitting packet to decoder:', { kind: 'decoding-failed' }],
  ['no decoder found for', { kind: 'no-decoder' }],
  ['not found for input stream', { kind: 'no-decoder' }],
  ['Unrecognized option', { kind: 'unknown-option' }],
];

/** Messages of demuxers that reached a wrong place of the file before its end. */
const IS_END = /ended prematurely|partial file|exceeds containing master element|invalid as first byte of an EBML/;
/** Prefix of the demuxer's messages from ffmpeg 7 on. */
const DEMUXER_PREFIX = '[in#0';
const SHOWN_PICTURE = /\[Parsed_showinfo\S* @ \S+\] \[info\] n: *(\d+) pts: *(\S+) .*? s:(\d+)x(\d+) .*?iskey:(\d)/g;
const TIME_BASE = /\[Parsed_showinfo\S* @ \S+\] \[info\] config in time_base: (\d+)\/(\d+)/;

/** Reads the log line by line. */
export class LogReader {
  #demuxers;
  #timeBase: TimeBase | null = null;

  /** @param demuxer ffmpeg's name of the file format */
  constructor(demuxer: string) {
    // ffmpeg 5 and 6 call the demuxer by its name.
    this.#demuxers = [DEMUXER_PREFIX, `[${demuxer} @`];
  }

  /** Returns the messages of a line in their order. */
  readLine(line: string): Message[] {
    const [, numerator, denominator] = TIME_BASE.exec(line) ?? [];
    if (numerator) this.#timeBase = { numerator: Number(numerator), denominator: Number(denominator) };
    const messages: { position: number; message: Message }[] = MESSAGES.flatMap(([text, message]) =>
      findAll(text, line).map((position) => ({ position, message })),
    );
    messages.push(...this.#findReadingFailures(line), ...this.#findShownPictures(line));
    return messages.sort((a, b) => a.position - b.position).map(({ message }) => message);
  }

  #findReadingFailures(line: string): { position: number; message: Message }[] {
    const places = this.#demuxers
      .flatMap((name) => findAll(name, line))
      .filter((position) => isErrorMessage(line.slice(position)));
    if (line.startsWith('[error] file:')) places.push(0);
    return places.map((position) => ({ position, message: { kind: 'reading-failed', isEnd: IS_END.test(line) } }));
  }

  #findShownPictures(line: string): { position: number; message: Message }[] {
    return [...line.matchAll(SHOWN_PICTURE)].map(
      ({ index: position = 0, 1: index, 2: pts, 3: width, 4: height, 5: key }) => {
        const ticks = Number(pts);
        const time = Number.isNaN(ticks) || !this.#timeBase ? null : toSeconds(ticks, this.#timeBase);
        const size = { width: Number(width), height: Number(height) };
        return { position, message: { kind: 'shown', index: Number(index), time, ...size, isKey: key === '1' } };
      },
    );
  }
}

function findAll(text: string, line: string) {
  const places = [];
  for (let position = line.indexOf(text); position >= 0; position = line.indexOf(text, position + 1))
    places.push(position);
  return places;
}

/** Returns true for `[name @ 0x12] [error] …`. */
const isErrorMessage = (message: string) => /^[^\]]*\] \[(?:error|fatal)\]/.test(message);

/**
 * A packet, which usually holds one picture: its decoding and display times in seconds, null if it has none, and how long
 * its picture is shown, 0 if the file does not say. It is shown unless an edit list drops it.
 */
export type Packet = {
  decodingTime: number | null;
  time: number | null;
  duration: number;
  isCorrupt: boolean;
  isShown: boolean;
};

/**
 * A video track that is no attached picture: its index among those (`0:V:position`), and its packets in file order.
 */
export type Track = { position: number; codec: string; numPixels: number; packets: Packet[] };

/** A picture of a packet; its duration is 0 if the file does not say. */
export type ListedPicture = { time: number; duration: number };

/** Relative tolerance within which steps between pictures are equal, for times in whole milliseconds. */
const STEP_TOLERANCE = 0.25;
/** Printed by ffmpeg as the time of a packet without one. */
const NO_TIME = '-9223372036854775808';
/** `AV_PKT_FLAG_CORRUPT`: the packet is not whole. */
const CORRUPT_FLAG = 2;
/** `AV_PKT_FLAG_DISCARD`: the packet is needed for decoding, but an edit list drops its picture. */
const DISCARD_FLAG = 4;

/** Reads the tracks in a list. */
export async function readTracks(list: AsyncIterable<Uint8Array>): Promise<Track[]> {
  const [reader, decoder] = [new ListReader(), new TextDecoder()];
  let rest = '';
  for await (const bytes of list) {
    const lines = (rest + decoder.decode(bytes, { stream: true })).split('\n');
    rest = lines.pop() ?? '';
    for (const line of lines) reader.readLine(line);
  }
  return reader.tracks;
}

/** Reads a list line by line. */
class ListReader {
  tracks: (Track & { timeBase: TimeBase })[] = [];

  readLine(line: string) {
    const [, name, position, text = ''] = /^#(\w+) (\d+): (.*)/.exec(line) ?? [];
    if (name) this.#readHeader(name, Number(position), text);
    else if (!line.startsWith('#')) this.#readPacket(line.split(',').map((word) => word.trim()));
  }

  #readHeader(name: string, position: number, text: string) {
    const [first, second] = text.split(/[/x]/).map(Number);
    const numbers = { numerator: Number(first), denominator: Number(second) };
    if (name === 'tb') this.tracks[position] = { position, timeBase: numbers, codec: '', numPixels: 0, packets: [] };
    const track = this.tracks[position];
    if (track && name === 'codec_id') track.codec = text;
    if (track && name === 'dimensions') track.numPixels = Number(first) * Number(second);
  }

  /** @param words track, decoding time, presentation time, duration, bytes, checksum, and optionally `F=0x2` */
  #readPacket([position, dts, pts, duration, , , ...more]: string[]) {
    const track = this.tracks[Number(position)];
    if (!track) return;
    const flags = Number(more.find((word) => word.startsWith('F='))?.slice(2) ?? 0);
    track.packets.push({
      decodingTime: dts === NO_TIME ? null : toSeconds(Number(dts), track.timeBase),
      time: pts === NO_TIME ? null : toSeconds(Number(pts), track.timeBase),
      duration: toSeconds(Math.max(0, Number(duration)), track.timeBase),
      isCorrupt: (flags & CORRUPT_FLAG) !== 0,
      isShown: (flags & DISCARD_FLAG) === 0,
    });
  }
}

const endsBeforeStart = ({ time, duration }: Packet) => time !== null && time < 0 && time + duration <= 0;

/** Returns the number of shown pictures. */
export function countPictures({ packets }: Track) {
  return packets.filter((packet) => packet.isShown && !endsBeforeStart(packet)).length;
}

/**
 * Returns the pictures whose time is known, in display order.
 *
 * If an MP4 file has durations only in its decoding times, ffmpeg 5 and 6 give all packets the average of the track. A
 * duration that all packets share, although the pictures are not evenly spaced, counts as unknown.
 */
export function listShownPictures({ packets }: Track): ListedPicture[] {
  const pictures = packets
    .flatMap(({ time, duration, isShown }) => (isShown && time !== null ? [{ time, duration }] : []))
    .sort((a, b) => a.time - b.time);
  const average = pictures[0]?.duration ?? 0;
  const isSteady = pictures.every(({ time }, k) => {
    const next = pictures[k + 1];
    return !next || Math.abs(next.time - time - average) <= STEP_TOLERANCE * average;
  });
  const isInvented = !isSteady && pictures.every(({ duration }) => duration === average);
  return isInvented ? pictures.map(({ time }) => ({ time, duration: 0 })) : pictures;
}

/**
 * Chooses the track of a clip: the first default track with several pictures, else the largest with several pictures,
 * else the largest with one.
 * @param defaults true for each default track
 */
export function chooseTrack(tracks: readonly Track[], defaults: readonly boolean[]): Track | undefined {
  const clips = tracks.filter((track) => countPictures(track) > 1);
  const preferred = clips.find(({ position }) => defaults[position]);
  return preferred ?? findLargest(clips) ?? findLargest(tracks.filter(({ packets }) => packets.length > 0));
}

function findLargest(tracks: readonly Track[]) {
  return tracks.reduce(
    (best: Track | undefined, track) => (best && best.numPixels >= track.numPixels ? best : track),
    undefined,
  );
}

/** Times that differ by less are equal, in seconds: far below the spacing of pictures, far above rounding. */
const SAME_TIME_S = 1e-6;

/** Factor from the step before; longer steps between pictures may have lost pictures in them. Chosen by eye. */
const LONG_STEP_FACTOR = 1.5;

/** Demuxers that cut packets out of a stream. */
const STREAM_DEMUXERS = ['mpegts', 'mpeg'];

/**
 * Compares decoded pictures with the packets of the file. Four things are damage:
 *
 * - a decoded picture that the decoder calls faulty;
 * - a packet that is not whole: pictures from its time on;
 * - a packet that could not be decoded: pictures after the first listed time without a picture. Packets before the first
 *   picture may fail, as where a recording begins between two key pictures;
 * - a file that could not be read on: pictures of the packets after that place, or what the end lacks. Some pictures before
 *   that place are shown later than lost ones, so times must not jump there.
 */
export class FaultFinder {
  #packets;
  /** Pictures in display order. */
  #listed;
  /** Pictures from one of these times on are damaged. */
  #damageTimes;
  #isCutOff;
  /** Pictures later than this may follow lost ones, in seconds. */
  #jumpTime = Infinity;
  #numRead = 0;
  #numDecoded = 0;
  #numFailed = 0;
  /** Numbers of decoded pictures. */
  #faulty = new Set<number>();
  /** Number of listed times before the first picture. */
  #numBeforeFirst = 0;
  #lastTime: number | null = null;
  #lastStep = Infinity;

  constructor(track: Track, demuxer: string) {
    const { packets } = track;
    this.#packets = packets;
    this.#listed = listShownPictures(track);
    // Where packets are cut out of a stream, each is complete, and takes over its mark, when the next begins.
    const late = STREAM_DEMUXERS.includes(demuxer) ? 1 : 0;
    const corruptPackets = packets.flatMap(({ isCorrupt }, index) => (isCorrupt ? [index + late] : []));
    this.#damageTimes = corruptPackets.flatMap((index) => packets[index]?.time ?? []);
    this.#isCutOff = corruptPackets.includes(packets.length);
  }

  /** Processes a message; messages come in the order of the log. */
  take(message: Message) {
    if (message.kind === 'packet-read') this.#numRead += 1;
    if (message.kind === 'decoded') this.#numDecoded += 1;
    if (message.kind === 'faulty') this.#faulty.add(this.#numDecoded);
    if (message.kind === 'decoding-failed') this.#numFailed += 1;
    if (message.kind === 'reading-failed') this.#takeReadingFailure(message.isEnd);
  }

  #takeReadingFailure(isEnd: boolean) {
    // ffmpeg probes the first packets before it reports one. A place among them is unknown.
    if (this.#numRead === 0 && !isEnd) return;
    const place = this.#numRead || this.#packets.length;
    const later = this.#packets.slice(place).flatMap(({ isShown, time }) => (isShown ? (time ?? []) : []));
    if (later.length > 0) this.#damageTimes.push(later.reduce((least, time) => Math.min(least, time)));
    else this.#isCutOff = true;
    // No lost picture is shown before its decoding time.
    const last = this.#packets[Math.min(place, this.#packets.length) - 1];
    const nextDecoding = last?.decodingTime == null ? Infinity : last.decodingTime + last.duration;
    this.#jumpTime = Math.min(this.#jumpTime, nextDecoding);
  }

  /** Returns true if the next picture is whole, and no picture before it is missing. */
  isWhole({ index, time }: ShownPicture) {
    if (this.#faulty.has(index)) return false;
    if (time === null) return true;
    const last = this.#lastTime;
    if (last === null) return !this.#damageTimes.some((damage) => Math.abs(damage - time) < SAME_TIME_S);
    const from = last + SAME_TIME_S;
    if (time > this.#jumpTime + SAME_TIME_S && time - last > LONG_STEP_FACTOR * this.#lastStep) return false;
    return !this.#isDamagedBetween(from, time + SAME_TIME_S) && !this.#isMissingBetween(from, time - SAME_TIME_S);
  }

  /** Records that a picture is yielded. */
  record({ time }: ShownPicture) {
    if (time === null) return;
    if (this.#lastTime === null) this.#numBeforeFirst = this.#countBefore(time - SAME_TIME_S);
    else this.#lastStep = time - this.#lastTime;
    this.#lastTime = time;
  }

  /** Returns how long the picture at a time is shown, in seconds; null if the file does not say. */
  getDuration(time: number | null) {
    const picture = time === null ? undefined : this.#listed[this.#countBefore(time - SAME_TIME_S)];
    return picture && Math.abs(picture.time - Number(time)) < SAME_TIME_S && picture.duration > 0
      ? picture.duration
      : null;
  }

  /** Returns true if nothing is missing after the last picture. */
  isWholeAtEnd() {
    if (this.#isCutOff) return false;
    if (this.#lastTime === null) return true;
    const from = this.#lastTime + SAME_TIME_S;
    return !this.#isDamagedBetween(from, Infinity) && !this.#isMissingBetween(from, Infinity);
  }

  #isDamagedBetween(from: number, to: number) {
    return this.#damageTimes.some((damage) => damage >= from && damage <= to);
  }

  /** Returns true if a listed time has no picture because its packet could not be decoded. */
  #isMissingBetween(from: number, to: number) {
    if (this.#numFailed <= this.#numBeforeFirst) return false;
    const next = this.#listed[this.#countBefore(from)];
    return next !== undefined && next.time <= to;
  }

  #countBefore(time: number) {
    let [low, high] = [0, this.#listed.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (Number(this.#listed[middle]?.time) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
