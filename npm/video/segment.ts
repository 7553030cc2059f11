// Video in, windows of masks out.

import { TraceCutError, illegal, isPlainObject } from '../check/errors.js';
import { type SessionOptions, type SplitOptions, splitOptions } from '../check/options.js';
import { Session } from '../session/session.js';
import { Pause, untilAborted } from '../worker/pause.js';
import { decoderLoader, openEngine } from '../worker/remote.js';
import { atSize, shownFrame } from './pixels.js';
import { WINDOWS } from '../parameters.js';
import { asOptions, expected, nothingTaken, splitTake, splitWindow, taken } from './reader.js';
import { Collector, type VideoResult } from './result.js';
import { type DecodedFrame, type VideoSource, openReader } from './source.js';
import { Driver, type WindowResult } from './window.js';
import type { Engine, Info, Stage } from '../session/engine.js';
import type { RawFrame } from '../worker/frames.js';
import type { Reader, Take, TakeOptions, TakenFrame } from './reader.js';

/**
 * Where the work is: `done` of `total` steps of a stage of window `window`; `'decode'` counts the frames read for it.
 * `frames` are the frames read so far and their number in all, null where nothing says.
 */
export type VideoProgress = {
  stage: Stage | 'decode';
  done: number;
  total: number;
  window: number;
  frames: { done: number; total: number | null };
};

/** How a clip is cut into windows. Memory grows with the window, not with the clip. */
export interface WindowOptions {
  /** The number of frames that are segmented together, 2 to 400, 50 if not given. */
  window?: number;
  /**
   * How many of them the next window shares, 1 to `window - 1`, 10 if not given (the last window of a clip of known
   * length shares more when it would not be full otherwise).
   */
  overlap?: number;
  /** Hears of each stage of each window, and of frames read. */
  onProgress?: (progress: VideoProgress) => void;
  /**
   * Is given each frame that is taken, as `videoFrames` gives it, before it is segmented; a promise that it gives is
   * waited for.
   */
  onFrame?: (frame: DecodedFrame) => void | Promise<void>;
  /**
   * Leaves the last window's session open at the end, as `session`. Its trajectories may be all that is wanted:
   * `clip.dense` may be off, and the windows, which have no masks then, are not collected.
   */
  keep?: boolean;
}

/** Options of `segmentVideo`: what to take of the source, how to cut it into windows, and the options of a session. */
export type VideoOptions = TakeOptions & SessionOptions & WindowOptions;

export interface Checked {
  take: Take;
  window: number;
  overlap: number | undefined;
  keep: boolean;
  onProgress: ((progress: VideoProgress) => void) | undefined;
  onFrame: WindowOptions['onFrame'];
  engine: SplitOptions;
}

function checked(options: unknown): Checked {
  const { take, others } = splitTake(asOptions(options));
  const { window, overlap, others: rest } = splitWindow(others);
  const { onProgress, onFrame, keep = false, ...engine } = rest;
  for (const [name, call] of Object.entries({ onProgress, onFrame }))
    if (call !== undefined && typeof call !== 'function') throw illegal('param', name, call, 'a function');
  if (typeof keep !== 'boolean') throw illegal('param', 'keep', keep, 'true or false');
  if (!keep && isPlainObject(engine.clip) && engine.clip.dense === false)
    throw illegal('param', 'clip.dense', false, 'true: segmentVideo makes masks');
  return {
    take,
    window,
    overlap,
    keep,
    onProgress: onProgress as Checked['onProgress'],
    onFrame: onFrame as Checked['onFrame'],
    engine: splitOptions(engine),
  };
}

/**
 * Segments a video: a file, an address, a video element, a stream, or frames one by one (Node takes the last only).
 * Long clips are run window by window, in bounded memory; labels keep their meaning from window to window, and a cut
 * begins a new shot with new ones.
 *
 * ```js
 * const video = segmentVideo(file, { size: 480, end: 10 });
 * for await (const window of video) {
 *   for (const { time, labels } of window.frames()) console.log(time, labels);
 * }
 * ```
 */
export function segmentVideo(source: VideoSource, options?: VideoOptions): VideoSegmentation {
  return new VideoSegmentation(source, checked(options));
}

/**
 * A clip on its way to masks; made by `segmentVideo`. Iterate over it for the windows' results as they come, or
 * `collect` them; either once. Nothing begins before that. While one result is looked at the next window is computed,
 * and no more than that. Leaving the loop early, `close`, an abort and an error end the work and free its memory;
 * `pause` only halts it, and `resume` goes on where it was.
 */
export class VideoSegmentation {
  #source;
  #checked;
  #begun = false;
  #closed = false;
  #stop = new AbortController();
  #pause = new Pause();
  #collector: Collector | undefined;
  #engine: Engine | undefined;
  #reader: Reader | undefined;
  #frames: ReturnType<typeof taken> | undefined;
  #session: Session | null = null;
  #total: number | null = null;
  #read = 0;
  /** What the source ended with before its end. */
  #damage: TraceCutError | null = null;

  constructor(source: VideoSource, checkedOptions: Checked) {
    this.#source = source;
    this.#checked = checkedOptions;
  }

  /** The windows' results, in order. */
  [Symbol.asyncIterator](): AsyncGenerator<WindowResult, void, undefined> {
    if (this.#begun)
      throw new TraceCutError(
        'state',
        'a video segmentation can be iterated over or collected once; call segmentVideo again',
      );
    if (this.#closed) throw new TraceCutError('closed', 'this video segmentation is closed; call segmentVideo again');
    this.#begun = true;
    return this.#windows();
  }

  /**
   * Segments the whole clip and gives everything in one: masks in a small form, times, shots, objects, trajectories.
   * `onWindow` is told of each window's result on the way; a promise that it gives is waited for. Of a source that is cut
   * off or damaged the result is of the frames before, and its `truncated` says so: it is given where there is an
   * `onDamage`, and else as the `result` of the error.
   */
  async collect(onWindow?: (window: WindowResult) => void | Promise<void>): Promise<VideoResult> {
    if (onWindow !== undefined && typeof onWindow !== 'function')
      throw illegal('param', 'onWindow', onWindow, 'a function');
    const windows = this[Symbol.asyncIterator]();
    const collector = (this.#collector = new Collector());
    try {
      for await (const window of windows) {
        await collector.add(window);
        this.#throwIfStopped();
        await onWindow?.(window);
      }
    } catch (error) {
      if (this.#damage && error === this.#damage) this.#damage.result = collector.finish(this.#damage);
      throw error;
    }
    return collector.finish(this.#damage);
  }

  /**
   * What `collect` has by now, of the frames whose masks are settled: a result like that of the whole clip, which stays
   * as it is while the work goes on. Null before the first window.
   */
  get collected(): VideoResult | null {
    return this.#collector?.sofar() ?? null;
  }

  /** The mask of frame `t`, as `VideoResult.labels`, as soon as `collect` has it. */
  labels(t: number): Uint8Array<ArrayBuffer> {
    if (!this.#collector)
      throw new TraceCutError('state', 'this video segmentation collects nothing: call collect first');
    return this.#collector.labels(t);
  }

  /**
   * With `keep`: the session of the last window, from the end of the loop or of `collect` on; null before. Where the clip
   * is one window it holds all of it, to be asked and corrected. Whoever asked for it closes it.
   */
  get session(): Session | null {
    return this.#session;
  }

  /** Frames of a window where nobody says, and how many of them the next one shares. */
  static get usual() {
    return { window: WINDOWS.frames, overlap: WINDOWS.overlap };
  }

  /**
   * Halts the work after the step under way; what is awaited waits, nothing is lost. Pausing twice is fine, and so is
   * pausing before the beginning or after the end.
   */
  pause() {
    this.#pause.begin();
  }

  /** Goes on where `pause` halted the work: the results are those of a clip that was never paused. */
  resume() {
    this.#pause.end();
  }

  /** Whether the work is paused. */
  get paused() {
    return this.#pause.on;
  }

  /**
   * Ends the work and frees its memory; what is awaited rejects with code `closed`. Results stay. Closing twice is
   * fine.
   */
  close() {
    if (this.#closed) return;
    this.#end(new TraceCutError('closed', 'the video segmentation was closed'));
  }

  /** The same as `close`. */
  free() {
    this.close();
  }

  /** `using video = segmentVideo(…)` closes it. */
  [Symbol.dispose]() {
    this.close();
  }

  async *#windows() {
    const { take } = this.#checked;
    const { signal } = take;
    const abort = () => this.#end(signal?.reason);
    try {
      signal?.throwIfAborted();
      signal?.addEventListener('abort', abort, { once: true });
      const driver = await untilAborted(this.#open(), this.#stop.signal);
      let next = this.#window(driver);
      for (;;) {
        const window = await next;
        if (!window) break;
        next = this.#window(driver);
        yield window;
      }
      if (this.#read === 0 && this.#reader) throw await nothingTaken(take, this.#reader);
      if (this.#damage && !take.onDamage) throw this.#damage;
      if (this.#checked.keep) this.#handOver(driver.info);
    } finally {
      signal?.removeEventListener('abort', abort);
      this.#end(new TraceCutError('closed', 'the video segmentation has ended'));
    }
  }

  async #open() {
    const { take, window, overlap, engine } = this.#checked;
    const loadDecoder = decoderLoader(engine.decoder);
    const reader = await openReader(this.#source, take, loadDecoder, engine.maxPixels);
    this.#reader = reader;
    this.#total = await expected(reader, take).catch(() => null);
    this.#throwIfStopped();
    this.#engine = await openEngine(engine);
    this.#throwIfStopped();
    await this.#engine.request('planWindows', window, overlap);
    // Damage ends the clip where it is pushed: files are decoded there.
    const frames = taken(reader, { ...take, onDamage: undefined });
    this.#frames = frames;
    const nextFrame = async () => {
      const { value, done } = await frames.next();
      if (done) return null;
      this.#read += 1;
      const { raw, ...facts } = value;
      const small = await atSize(raw, take.size);
      await this.#show(small, facts);
      const { time, end, clip } = facts;
      return { raw: small, time, end, clip };
    };
    return new Driver({
      engine: this.#engine,
      nextFrame,
      left: () => (this.#total === null ? null : Math.max(0, this.#total - this.#read)),
      window,
      stop: this.#stop.signal,
      pause: this.#pause,
      onDamage: (error, count) => {
        this.#damage = error;
        take.onDamage?.({ frames: count, total: this.#total, error });
      },
      onStage: ({ stage, done, total }, index) => this.#report({ stage, done, total, window: index }),
      onFrame: (done, index) =>
        this.#report({ stage: 'decode', done, total: Math.max(done, this.#inWindow(done)), window: index }),
    });
  }

  /** How many frames a window that has `done` of them will have. */
  #inWindow(done: number) {
    const left = this.#total === null ? Infinity : this.#total - this.#read;
    return Math.min(this.#checked.window, done + left);
  }

  /** The next window, computed at once and awaited later: its error, if nobody ever waits for it, is nobody's. */
  #window(driver: Driver) {
    const window = untilAborted(driver.next(), this.#stop.signal);
    window.catch(() => {});
    return window;
  }

  async #show(raw: RawFrame, { end: _, ...facts }: Omit<TakenFrame, 'raw'>) {
    const { onFrame } = this.#checked;
    if (!onFrame) return;
    const { close, ...shown } = await shownFrame(raw, undefined, facts.time);
    try {
      await onFrame({ ...shown, ...facts });
    } finally {
      close();
    }
  }

  #report(progress: Omit<VideoProgress, 'frames'>) {
    if (this.#stop.signal.aborted) return;
    try {
      this.#checked.onProgress?.({ ...progress, frames: { done: this.#read, total: this.#total } });
    } catch (error) {
      this.#end(error);
    }
  }

  /** What was opened after the end is closed at once. */
  #throwIfStopped() {
    if (!this.#stop.signal.aborted) return;
    this.#release();
    throw this.#stop.signal.reason;
  }

  #handOver(info: Info | undefined) {
    const [engine, { decoder, maxPixels }] = [this.#engine, this.#checked.engine];
    if (!engine) return;
    this.#engine = undefined;
    engine.rest();
    this.#session = new Session(engine, decoderLoader(decoder), maxPixels, info);
  }

  #end(reason: unknown) {
    this.#closed = true;
    if (!this.#stop.signal.aborted) this.#stop.abort(reason);
    this.#pause.close();
    this.#release();
  }

  #release() {
    this.#frames?.return().catch(() => {});
    this.#reader?.close();
    this.#engine?.close();
  }
}

/**
 * Frames that are far apart show motion that few of them suffice to see; much farther, and fast things are lost. Figures
 * for other choices are in docs/speed.md.
 */
const USUAL = { step: 2, maxFrames: 8, threads: 1 };
const USUAL_SIDE = 320;

/**
 * Coarse masks of a clip's first frames, long before its own are there: those of frames 0, 2, 4, … 14, made from pictures
 * of at most 320 pixels, on one thread. Where something moves is mostly right; small and slow things may be missing, and
 * labels are not those that the whole clip will have. Takes what `segmentVideo` takes, with `step: 2`, `maxFrames: 8`,
 * `threads: 1` and `clip.maxSide: 320` where the options say nothing else, and rejects as that does.
 *
 * ```js
 * const coarse = await previewMasks(file, { size: 480 });
 * drawLabels(context, coarse, 0);
 * ```
 * @returns of the frames taken, at the size of the source or `size`
 */
export async function previewMasks(source: VideoSource, options?: VideoOptions): Promise<VideoResult> {
  const { clip = {}, ...given } = asOptions(options) as VideoOptions;
  if (!isPlainObject(clip)) throw illegal('param', 'clip', clip, 'an object such as {maxSide: 240}');
  const taken = Object.fromEntries(Object.entries(given).filter(([, value]) => value !== undefined));
  const maxSide = clip.maxSide ?? USUAL_SIDE;
  return segmentVideo(source, { ...USUAL, ...taken, clip: { ...clip, maxSide } }).collect();
}
