// Segments a video window by window.

import { TraceCutError, illegal, isPlainObject } from '../check/errors.js';
import { type EngineOptions, type SessionOptions, splitOptions } from '../check/options.js';
import { ClipWork, type RunEstimate, RunMeter, STAGES_OF_MASKS } from '../session/progress.js';
import { Session } from '../session/session.js';
import { Pause, untilAborted } from '../worker/pause.js';
import { createDecoderLoader, openEngine } from '../worker/remote.js';
import { reduceFrame, toShownFrame } from './pixels.js';
import { WINDOWS } from '../parameters.js';
import {
  TAKE_NAMES,
  WINDOW_NAMES,
  asOptions,
  countExpected,
  createEmptyError,
  splitTake,
  splitWindow,
  takeFrames,
} from './reader.js';
import { Collector, type VideoResult } from './result.js';
import { type DecodedFrame, type VideoSource, openReader } from './source.js';
import { Driver, type WindowResult } from './window.js';
import type { Engine, SessionInfo, Stage } from '../session/engine.js';
import type { RawFrame } from '../worker/frames.js';
import type { Reader, SelectedFrame, Take, TakeOptions } from './reader.js';

/**
 * Progress of a video: `done` of `total` steps of a stage of window `window`; `'decode'` counts the frames read for it.
 * `frames` is the number of frames read so far and the total, null if unknown.
 */
export type VideoProgress = {
  stage: Stage | 'decode';
  done: number;
  total: number;
  window: number;
  frames: { done: number; total: number | null };
  /**
   * Finished share of the whole clip, 0 to 1, over all windows, as estimated from the usual times of the stages; it never
   * falls, and the last report has 1. 0 while the number of frames is unknown: the length of a stream is known when it ends.
   */
  share: number;
  /** Estimated time left in seconds; null while it or the number of frames is unknown. */
  secondsLeft: number | null;
};

type WindowProgress = Pick<VideoProgress, 'stage' | 'done' | 'total' | 'window'>;

/** Options of windows. Memory grows with the window, not with the clip. */
export interface WindowOptions {
  /** Number of frames that are segmented together, 2 to 400, 50 if not given. */
  window?: number;
  /**
   * Number of frames shared with the next window, 1 to `window - 1`, 10 if not given. The last window of a clip of known
   * length shares more if it would not be full otherwise.
   */
  overlap?: number;
  /** Called for each stage of each window, and for frames read. */
  onProgress?: (progress: VideoProgress) => void;
  /**
   * Called with each selected frame, as `videoFrames` yields it, before it is segmented; a returned promise is awaited.
   */
  onFrame?: (frame: DecodedFrame) => void | Promise<void>;
  /**
   * Keeps the last window's session open as `session`. It may be used for trajectories only: `clip.dense` may be off then,
   * and the windows, which have no masks, are not collected.
   */
  keep?: boolean;
}

/** Options of `segmentVideo`: selection of frames, windows, and the options of a session. */
export type VideoOptions = TakeOptions & SessionOptions & WindowOptions;

export interface SegmentOptions {
  take: Take;
  window: number;
  overlap: number | undefined;
  keep: boolean;
  onProgress: ((progress: VideoProgress) => void) | undefined;
  onFrame: WindowOptions['onFrame'];
  engine: EngineOptions;
}

function checkSegmentOptions(options: unknown): SegmentOptions {
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
    onProgress: onProgress as SegmentOptions['onProgress'],
    onFrame: onFrame as SegmentOptions['onFrame'],
    engine: splitOptions(engine, { others: [...TAKE_NAMES, ...WINDOW_NAMES, 'onProgress', 'onFrame', 'keep'] }),
  };
}

/**
 * Segments a video: a file, an address, a video element, a stream, or single frames (Node takes single frames, and files by
 * path if ffmpeg is installed). Long clips run window by window, in bounded memory; labels keep their meaning from window
 * to window, and a cut starts a new shot with new labels.
 *
 * ```js
 * const video = segmentVideo(file, { size: 480, end: 10 });
 * for await (const window of video) {
 *   for (const { time, labels } of window.frames()) console.log(time, labels);
 * }
 * ```
 */
export function segmentVideo(source: VideoSource, options?: VideoOptions): VideoSegmentation {
  return new VideoSegmentation(source, checkSegmentOptions(options));
}

/**
 * Segments a clip; created by `segmentVideo`. Iterate over it for the results of its windows, read them from `readable`, or
 * `collect` them; one of these, once. Nothing starts before that. While a result is processed the next window is computed,
 * but no further one. Leaving the loop early, `close`, an abort and an error end the work and free its memory; `pause` only
 * halts it, and `resume` continues.
 */
export class VideoSegmentation {
  #source;
  #checked;
  #hasStarted = false;
  #isClosed = false;
  #stop = new AbortController();
  #pause = new Pause();
  #collector: Collector | undefined;
  #engine: Engine | undefined;
  #reader: Reader | undefined;
  #frames: ReturnType<typeof takeFrames> | undefined;
  #session: Session | null = null;
  #readable: ReadableStream<WindowResult> | undefined;
  #total: number | null = null;
  #numRead = 0;
  /** True once the last frame is read. */
  #isRead = false;
  #lastProgress: VideoProgress | undefined;
  #meter: { meter: RunMeter; firstFrame: number; firstWindow: number } | undefined;
  /** Error that ended the source early. */
  #damage: TraceCutError | null = null;

  constructor(source: VideoSource, checkedOptions: SegmentOptions) {
    this.#source = source;
    this.#checked = checkedOptions;
  }

  /** Yields the windows' results, in order. */
  [Symbol.asyncIterator](): AsyncGenerator<WindowResult, void, undefined> {
    if (this.#hasStarted)
      throw new TraceCutError(
        'state',
        'a video segmentation can be iterated over or collected once; call segmentVideo again',
      );
    if (this.#isClosed) throw new TraceCutError('closed', 'this video segmentation is closed; call segmentVideo again');
    this.#hasStarted = true;
    return this.#runWindows();
  }

  /**
   * The windows' results as a stream, such as for `pipeTo`. It begins when it is first read, computes at most one window
   * ahead, and cancelling it closes the segmentation.
   */
  get readable(): ReadableStream<WindowResult> {
    return (this.#readable ??= this.#createStream());
  }

  /**
   * Segments the whole clip and returns everything in one result: compact masks, times, shots, objects, trajectories.
   * `onWindow` is called with each window's result; a returned promise is awaited. If the source is cut off or damaged, the
   * result has the frames before, and `truncated` says so: it is returned if there is an `onDamage`, else it is the
   * `result` of the error.
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
   * The partial result of `collect` for the frames whose masks are settled: like the result of the whole clip, and unchanged
   * while the work continues. Null before the first window.
   */
  get collected(): VideoResult | null {
    return this.#collector?.createPartialResult() ?? null;
  }

  /** Returns the mask of frame `t`, as `VideoResult.labels`, as soon as `collect` has it. */
  labels(t: number): Uint8Array<ArrayBuffer> {
    if (!this.#collector) throw new TraceCutError('state', 'labels(t) needs collect(): call it first');
    return this.#collector.labels(t);
  }

  /**
   * With `keep`: the session of the last window, after the loop or `collect` has ended; null before. If the clip is one
   * window it holds all of it, for requests and corrections. The caller closes it.
   */
  get session(): Session | null {
    return this.#session;
  }

  /** Default number of frames of a window, and of frames shared with the next one. */
  static get defaults() {
    return { window: WINDOWS.frames, overlap: WINDOWS.overlap };
  }

  /**
   * Halts the work after the present step; pending promises wait, nothing is lost. Pausing twice is fine, and so is pausing
   * before the start or after the end.
   */
  pause() {
    this.#pause.begin();
  }

  /** Continues after `pause`; the results do not depend on pauses. */
  resume() {
    this.#meter?.meter.resume();
    this.#pause.end();
  }

  /** True while the work is paused. */
  get paused() {
    return this.#pause.isHalted;
  }

  /** Ends the work and frees its memory; pending promises reject with code `closed`. Results stay. Closing twice is fine. */
  close() {
    if (this.#isClosed) return;
    this.#end(new TraceCutError('closed', 'the video segmentation was closed'));
  }

  /** Same as `close`. */
  free() {
    this.close();
  }

  /** Closes it at the end of `using video = segmentVideo(…)`. */
  [Symbol.dispose]() {
    this.close();
  }

  #createStream() {
    let windows: AsyncGenerator<WindowResult, void, undefined> | undefined;
    const pull = async (controller: ReadableStreamDefaultController<WindowResult>) => {
      const { value, done } = await (windows ??= this[Symbol.asyncIterator]()).next();
      if (done) controller.close();
      else controller.enqueue(value);
    };
    const cancel = async () => {
      this.close();
      await windows?.return();
    };
    // Without a queue of its own: nothing is computed before it is read.
    return new ReadableStream<WindowResult>({ pull, cancel }, { highWaterMark: 0 });
  }

  async *#runWindows() {
    const { take } = this.#checked;
    const { signal } = take;
    const abort = () => this.#end(signal?.reason);
    try {
      signal?.throwIfAborted();
      signal?.addEventListener('abort', abort, { once: true });
      const driver = await untilAborted(this.#open(), this.#stop.signal);
      let next = this.#startWindow(driver);
      for (;;) {
        const window = await next;
        if (!window) break;
        next = this.#startWindow(driver);
        yield window;
      }
      this.#reportEnd();
      if (this.#numRead === 0 && this.#reader) throw await createEmptyError(take, this.#reader);
      if (this.#damage && !take.onDamage) throw this.#damage;
      if (this.#checked.keep) this.#keepSession(driver.info);
    } finally {
      signal?.removeEventListener('abort', abort);
      this.#end(new TraceCutError('closed', 'the video segmentation has ended'));
    }
  }

  async #open() {
    const { take, window, engine } = this.#checked;
    const loadDecoder = createDecoderLoader(engine.decoder);
    const opening = this.#openEngine();
    opening.catch(() => {});
    const reader = await openReader(this.#source, take, loadDecoder, {
      maxPixels: engine.maxPixels,
      maxQueue: window,
    });
    this.#reader = reader;
    this.#total = await countExpected(reader, take).catch(() => null);
    this.#throwIfStopped();
    const openedEngine = await opening;
    // Damage ends the clip when a file is pushed, as it is decoded then.
    const frames = takeFrames(reader, { ...take, onDamage: undefined });
    this.#frames = frames;
    const read = async () => {
      const { value, done } = await frames.next();
      if (done) return null;
      const { raw, ...facts } = value;
      return { raw: await reduceFrame(raw, take.size), facts, isDecoded: raw.kind === 'image' };
    };
    let ahead: ReturnType<typeof read> | undefined;
    const nextFrame = async () => {
      const frame = await (ahead ?? read());
      this.#isRead = frame === null;
      if (!frame) return null;
      // A file is decoded and reduced while the engine works. Streams are not read before their frames are used.
      ahead = frame.isDecoded ? read() : undefined;
      ahead?.catch(() => {});
      this.#numRead += 1;
      const { raw, facts } = frame;
      await this.#callOnFrame(raw, facts);
      const { time, end, clip } = facts;
      return { raw, time, end, clip };
    };
    return new Driver({
      engine: openedEngine,
      nextFrame,
      countRemaining: () => (this.#total === null ? null : Math.max(0, this.#total - this.#numRead)),
      window,
      stop: this.#stop.signal,
      pause: this.#pause,
      onDamage: (error, count) => {
        this.#damage = error;
        this.#isRead = true;
        this.#numRead = count;
        take.onDamage?.({ frames: count, total: this.#total, error });
      },
      onStage: ({ stage, done, total }, index) => this.#report({ stage, done, total, window: index }),
      onFrame: (done, index) =>
        this.#report({ stage: 'decode', done, total: Math.max(done, this.#expectedInWindow(done)), window: index }),
    });
  }

  async #openEngine() {
    const { window, overlap, engine } = this.#checked;
    this.#engine = await openEngine(engine);
    // It may have taken longer than the source took to fail.
    this.#throwIfStopped();
    await this.#engine.request('planWindows', window, overlap);
    return this.#engine;
  }

  /** Returns the expected size of a window that has `done` frames. */
  #expectedInWindow(done: number) {
    const remaining = this.#total === null ? Infinity : this.#total - this.#numRead;
    return Math.min(this.#checked.window, done + remaining);
  }

  /** Starts the next window; if it is never awaited, its error is ignored. */
  #startWindow(driver: Driver) {
    const window = untilAborted(driver.next(), this.#stop.signal);
    window.catch(() => {});
    return window;
  }

  async #callOnFrame(raw: RawFrame, { end: _, ...facts }: Omit<SelectedFrame, 'raw'>) {
    const { onFrame } = this.#checked;
    if (!onFrame) return;
    const { close, ...shown } = await toShownFrame(raw, undefined, facts.time);
    try {
      await onFrame({ ...shown, ...facts });
    } finally {
      close();
    }
  }

  #report(step: WindowProgress) {
    const frames = { done: this.#numRead, total: this.#isRead ? this.#numRead : this.#total };
    this.#callOnProgress({ ...step, frames, ...this.#estimate(step, frames.total) });
  }

  /** Repeats the last report if the clip ended earlier than expected, by damage or a cut. */
  #reportEnd() {
    const last = this.#lastProgress;
    if (!last || last.share === 1) return;
    const frames = { done: this.#numRead, total: this.#numRead };
    this.#callOnProgress({ ...last, frames, share: 1, secondsLeft: 0 });
  }

  #callOnProgress(progress: VideoProgress) {
    if (this.#stop.signal.aborted) return;
    this.#lastProgress = progress;
    try {
      this.#checked.onProgress?.(progress);
    } catch (error) {
      this.#end(error);
    }
  }

  /** Estimates the whole clip's progress; of a source of unknown length, the progress of what is left when it ends. */
  #estimate({ stage, done, total, window }: WindowProgress, numFrames: number | null): RunEstimate {
    if (numFrames === null) return { share: 0, secondsLeft: null };
    this.#meter ??= this.#createMeter(numFrames, window);
    const { meter, firstFrame, firstWindow } = this.#meter;
    const [numRead, numLeft] = [this.#numRead - firstFrame, Math.max(this.#numRead, numFrames) - firstFrame];
    if (stage === 'decode') return meter.countRead(numRead, numLeft);
    return meter.countStep({ stage, done, total, window: window - firstWindow }, numRead, numLeft);
  }

  #createMeter(numFrames: number, firstWindow: number) {
    const { window, overlap = Math.min(WINDOWS.overlap, window - 1), engine } = this.#checked;
    const isKnown = this.#total !== null;
    const numLeft = isKnown ? numFrames : Math.min(numFrames, window);
    const isDense = (engine.parameters.clip as SessionOptions['clip'])?.dense !== false;
    const work = new ClipWork(numLeft, window, overlap, isKnown);
    return { meter: new RunMeter(work, isDense ? [] : STAGES_OF_MASKS), firstFrame: numFrames - numLeft, firstWindow };
  }

  /** Closes at once anything that was opened after the end. */
  #throwIfStopped() {
    if (!this.#stop.signal.aborted) return;
    this.#free();
    throw this.#stop.signal.reason;
  }

  #keepSession(info: SessionInfo | undefined) {
    const [engine, options] = [this.#engine, this.#checked.engine];
    if (!engine) return;
    this.#engine = undefined;
    engine.rest();
    this.#session = new Session(engine, createDecoderLoader(options.decoder), options, info);
  }

  #end(reason: unknown) {
    this.#isClosed = true;
    if (!this.#stop.signal.aborted) this.#stop.abort(reason);
    this.#pause.close();
    this.#free();
  }

  #free() {
    this.#frames?.return().catch(() => {});
    this.#reader?.close();
    this.#engine?.close();
  }
}

/**
 * Options of a preview: a few frames that are far apart are enough to see motion; if they were much farther, fast objects
 * would be lost. docs/speed.md compares other choices.
 */
const PREVIEW = { step: 2, maxFrames: 8, threads: 1 };
/** Default of `clip.maxSide` for a preview. */
const PREVIEW_SIDE = 320;

/**
 * Computes coarse masks of a clip's first frames quickly: frames 0, 2, 4, … 14, from pictures of at most 320 pixels, on one
 * thread. Moving areas are mostly right; small and slow objects may be missing, and the labels differ from the labels of the
 * whole clip. Takes the options of `segmentVideo`, with defaults `step: 2`, `maxFrames: 8`, `threads: 1` and
 * `clip.maxSide: 320`, and rejects in the same cases.
 *
 * ```js
 * const coarse = await previewMasks(file, { size: 480 });
 * drawLabels(context, coarse, 0);
 * ```
 * @returns for the selected frames, at the size of the source or `size`
 */
export async function previewMasks(source: VideoSource, options?: VideoOptions): Promise<VideoResult> {
  const { clip = {}, ...videoOptions } = asOptions(options) as VideoOptions;
  if (!isPlainObject(clip)) throw illegal('param', 'clip', clip, 'an object such as {maxSide: 240}');
  const defined = Object.fromEntries(Object.entries(videoOptions).filter(([, value]) => value !== undefined));
  const maxSide = clip.maxSide ?? PREVIEW_SIDE;
  return segmentVideo(source, { ...PREVIEW, ...defined, clip: { ...clip, maxSide } }).collect();
}
