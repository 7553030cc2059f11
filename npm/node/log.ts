// Messages that ffmpeg logs while it decodes (`-loglevel level+info -debug_ts`, filter `showinfo`).
//
// Checked with ffmpeg 5.1 and 9. Its threads write at once: one may begin a message on the line of another, but the words
// looked for here are never torn. `cli/src/ffmpeg/log.rs` reads the same.

/** A unit of time in seconds, as a fraction. */
export type TimeBase = { numerator: number; denominator: number };

export const toSeconds = (ticks: number, { numerator, denominator }: TimeBase) => (ticks * numerator) / denominator;

/**
 * A picture as the filters give it, next on standard output: its number, its time in seconds (null where the file has none)
 * and its size in pixels.
 */
export type Shown = {
  kind: 'shown';
  index: number;
  time: number | null;
  width: number;
  height: number;
  isKey: boolean;
};

/**
 * A message that tells something of the pictures. `reading-failed` is about the file, and `isEnd` if its words say that it
 * ended too early; `decoding-failed` is about a packet; `faulty` comes before the `decoded` of the same picture.
 */
export type Message =
  | Shown
  | { kind: 'packet-read' | 'decoding-failed' | 'faulty' | 'decoded' | 'no-decoder' | 'unknown-option' }
  | { kind: 'reading-failed'; isEnd: boolean };

const WORDS: [words: string, message: Message][] = [
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

/** Words of demuxers that have come to a wrong place of the file before its end. */
const IS_END = /ended prematurely|partial file|exceeds containing master element|invalid as first byte of an EBML/;
/** Begins the messages of the demuxer from ffmpeg 7 on. */
const DEMUXER = '[in#0';
const SHOWN = /\[Parsed_showinfo\S* @ \S+\] \[info\] n: *(\d+) pts: *(\S+) .*? s:(\d+)x(\d+) .*?iskey:(\d)/g;
const TIME_BASE = /\[Parsed_showinfo\S* @ \S+\] \[info\] config in time_base: (\d+)\/(\d+)/;

/** Reads the log line by line. */
export class LogReader {
  #demuxers;
  #timeBase: TimeBase | null = null;

  /** @param demuxer what ffmpeg calls the format of the file */
  constructor(demuxer: string) {
    // ffmpeg 5 and 6 call the demuxer by its name.
    this.#demuxers = [DEMUXER, `[${demuxer} @`];
  }

  /** Returns the messages of a line in their order. */
  readLine(line: string): Message[] {
    const [, numerator, denominator] = TIME_BASE.exec(line) ?? [];
    if (numerator) this.#timeBase = { numerator: Number(numerator), denominator: Number(denominator) };
    const found: { at: number; message: Message }[] = WORDS.flatMap(([words, message]) =>
      placesOf(words, line).map((at) => ({ at, message })),
    );
    found.push(...this.#readingFailures(line), ...this.#shown(line));
    return found.sort((a, b) => a.at - b.at).map(({ message }) => message);
  }

  #readingFailures(line: string): { at: number; message: Message }[] {
    const places = this.#demuxers.flatMap((name) => placesOf(name, line)).filter((at) => isError(line.slice(at)));
    if (line.startsWith('[error] file:')) places.push(0);
    return places.map((at) => ({ at, message: { kind: 'reading-failed', isEnd: IS_END.test(line) } }));
  }

  #shown(line: string): { at: number; message: Message }[] {
    return [...line.matchAll(SHOWN)].map(({ index: at = 0, 1: index, 2: pts, 3: width, 4: height, 5: key }) => {
      const ticks = Number(pts);
      const time = Number.isNaN(ticks) || !this.#timeBase ? null : toSeconds(ticks, this.#timeBase);
      const size = { width: Number(width), height: Number(height) };
      return { at, message: { kind: 'shown', index: Number(index), time, ...size, isKey: key === '1' } };
    });
  }
}

function placesOf(words: string, line: string) {
  const places = [];
  for (let at = line.indexOf(words); at >= 0; at = line.indexOf(words, at + 1)) places.push(at);
  return places;
}

/** Returns true for `[name @ 0x12] [error] …`. */
const isError = (message: string) => /^[^\]]*\] \[(?:error|fatal)\]/.test(message);
