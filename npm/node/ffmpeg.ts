// Runs an installed ffmpeg: its arguments, output and exit.
//
// The command line (cli/src/ffmpeg.rs) uses the same arguments; a test compares them.

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
