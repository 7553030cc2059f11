// Parses the messages that ffmpeg logs while it decodes (`-loglevel level+info -debug_ts`, filter `showinfo`).
//
// Checked with ffmpeg 5.1 and 9. Its threads write at once: one may begin a message on another's line, but the words
// searched for here are never split. `cli/src/ffmpeg/log.rs` does the same.

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
