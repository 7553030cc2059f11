// An installed ffmpeg at work: what it is asked for, and how it ends.
//
// The command line (cli/src/ffmpeg.rs) asks for the same in the same words; a test compares them.

import { spawn } from 'node:child_process';
import { TraceCutError } from '../check/errors.js';

/** Before the input, in both runs: each message with its level; times as they are in the file, without an offset. */
export const GENERAL = ['-hide_banner', '-nostdin', '-nostats', '-loglevel', 'level+info', '-copyts'];

/** After the input, in the first run: a line for each packet of each video track that is no attached picture. */
export const LIST = ['-map', '0:V', '-c', 'copy', '-copyinkf', '-f', 'framecrc'];

/**
 * Before the input, in the second run: a message for each packet that is read and each picture that is decoded; one
 * thread, as with several ffmpeg 5.1 forgets to call some pictures faulty; one chain of filters for all pictures, so that
 * later ones are scaled to the size of the first.
 */
export const DECODE = ['-debug_ts', '-threads', '1', '-reinit_filter', '0'];

/**
 * Square pixels, never fewer of them; the same bytes of RGB from every version; a message for each picture. At last, times
 * that increase, as what writes the pictures wants them.
 */
export const FILTERS =
  "scale=w='if(gt(sar,1),round(iw*sar),iw)':h='if(gt(sar,1),ih,round(ih/sar))':" +
  'flags=bicubic+accurate_rnd+full_chroma_int+bitexact,' +
  'setsar=1,format=rgb24,showinfo=checksum=0,settb=1/25,setpts=N';

/** After the input and the track, in the second run: each picture once, as bytes of RGB. */
export const WRITE = ['-fps_mode', 'passthrough', '-vf', FILTERS, '-f', 'rawvideo'];

/** A run of ffmpeg: bytes on `output`, and messages line by line. */
export class Ffmpeg {
  #child;
  #signal;
  #failure: NodeJS.ErrnoException | undefined;
  #rest = '';
  #lines: string[] = [];
  #isSilent = false;
  #wake: () => void = () => {};

  /** Resolves to the exit code, null if it was ended. */
  ended: Promise<number | null>;

  /** @param options the arguments before and after the input, besides those of all runs */
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
    this.#child.stderr.setEncoding('utf8').on('data', (text) => this.#hear(text));
    this.#child.stderr.on('close', () => {
      this.#isSilent = true;
      this.#wake();
    });
    this.ended = new Promise((resolve) => this.#child.on('close', resolve));
  }

  get output() {
    return this.#child.stdout;
  }

  /**
   * Gives the lines that it writes to standard error, to the last.
   * @throws the signal's reason, or error `unsupported` where ffmpeg could not be started
   */
  async *lines() {
    for (;;) {
      const line = this.#lines.shift();
      if (line !== undefined) yield line;
      else if (this.#isSilent) break;
      else await new Promise((resolve: (value: void) => void) => (this.#wake = resolve));
    }
    this.#signal?.throwIfAborted();
    if (this.#failure) throw notStarted(this.#failure, this.#child.spawnfile);
  }

  end() {
    this.#child.kill('SIGKILL');
  }

  #hear(text: string) {
    const lines = (this.#rest + text).split('\n');
    this.#rest = lines.pop() ?? '';
    this.#lines.push(...lines);
    this.#wake();
  }
}

function notStarted(error: NodeJS.ErrnoException, name: string) {
  const reason = error.code === 'ENOENT' ? 'it was not found' : error.message;
  const words =
    `${name} could not be started: ${reason} (expected ffmpeg to be installed, or its path as the option ffmpeg; ` +
    'without it pass frames, such as the bytes of PNG or JPEG files)';
  return new TraceCutError('unsupported', words, { cause: error });
}
