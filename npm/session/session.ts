// Processes one clip at a time: `Session` checks its inputs, runs, aborts and corrects; an engine does the work.

import { TraceCutError, checkOptions, checkWholeNumber, illegal, withFrame } from '../check/errors.js';
import { type EngineOptions, type SessionOptions, splitOptions } from '../check/options.js';
import { type BoundaryMap, type Grid, type Superpixels, addScale } from '../stages/image.js';
import { type FrameSource, toRawFrame } from '../worker/frames.js';
import { untilAborted } from '../worker/pause.js';
import { createDecoderLoader, openEngine } from '../worker/remote.js';
import { ClipWork, type Progress, RunMeter, STAGES_OF_FRAMES, STAGES_OF_MASKS } from './progress.js';
import {
  type Answer,
  type Arguments,
  type Ask,
  type MapName,
  type Place,
  REQUESTS,
  type RawCorrection,
  type ResultRequestSpec,
  type Stroke,
  type TrajectoryInput,
  toMerge,
  toRawTrajectories,
  toSplit,
  toStrokes,
} from './requests.js';
import { type Background, Result, type SaliencyMap } from './result.js';
import type { Engine, FlowField, OnStep, SessionInfo } from './engine.js';
import type { ParameterOptions } from '../parameters.js';

/** Opens a session. */
export async function createSession(options?: SessionOptions): Promise<Session> {
  const split = splitOptions(options);
  return new Session(await openEngine(split), createDecoderLoader(split.decoder), split);
}

const EMPTY_INFO: SessionInfo = {
  numFrames: 0,
  width: 0,
  height: 0,
  workingWidth: 0,
  workingHeight: 0,
  corrections: 0,
  memoryBytes: 0,
};

/** Options of a run or a correction. */
export interface RunOptions {
  /** Called for each stage, with the finished share of the run and the time left. */
  onProgress?: (progress: Progress) => void;
  /** Aborts the work: the promise rejects with its reason, and the session keeps its state. */
  signal?: AbortSignal;
}

/**
 * Closes the engines of sessions that were dropped without `close`, as nothing else would end their workers. A pending run
 * or push, and a result that may still send requests, keep their session. Some engines, such as older workerd, never report
 * dropped objects.
 */
const droppedSessions: FinalizationRegistry<Engine> | undefined =
  typeof FinalizationRegistry === 'undefined'
    ? undefined
    : /* @__PURE__ */ new FinalizationRegistry((engine) => engine.close());

/**
 * Computes labelled trajectories and masks of one clip. Created by `createSession`. `push` adds frames, `run` processes
 * them, results are plain arrays that outlive the session; only superpixels, boundaries and saliency maps are computed on
 * request.
 */
export class Session {
  #engine;
  #info = EMPTY_INFO;
  #closed = false;
  /** Increased when the session is cleared. */
  #clipNumber = 0;
  /** Increased by each correction. */
  #numCorrections = 0;
  /** Aborts the present run. */
  #stopRun: ((reason: unknown) => void) | undefined;

  /** Number of frames pushed, or being pushed. */
  #numPushed = 0;
  #loadDecoder;
  #maxPixels;
  #isDense;
  /** Keeps the frames in the order of the calls, however long copying takes. */
  #lastCopy: Promise<unknown> = Promise.resolve();

  /** @param info state of the engine */
  constructor(
    engine: Engine,
    loadDecoder: () => Promise<WebAssembly.Module>,
    { maxPixels, parameters = {} }: Partial<Pick<EngineOptions, 'maxPixels' | 'parameters'>> = {},
    info: SessionInfo = EMPTY_INFO,
  ) {
    this.#maxPixels = maxPixels;
    this.#isDense = (parameters.clip as ParameterOptions['clip'])?.dense ?? true;
    this.#engine = engine;
    this.#info = info;
    this.#numPushed = info.numFrames;
    this.#loadDecoder = loadDecoder;
    droppedSessions?.register(this, engine, this);
  }

  /** Number of frames pushed so far, or of the given trajectories' clip. */
  get numFrames() {
    return this.#info.numFrames;
  }

  /** Width of the input frames in pixels; 0 before the first. */
  get width() {
    return this.#info.width;
  }

  /** Height of the input frames in pixels; 0 before the first. */
  get height() {
    return this.#info.height;
  }

  /** Adds the next frame. All frames of a session have one size. */
  async push(frame: FrameSource): Promise<void> {
    this.#check('push');
    const before = this.#lastCopy;
    const copying = toRawFrame(frame, this.#loadDecoder, this.#maxPixels);
    this.#lastCopy = Promise.allSettled([before, copying]);
    await before;
    const raw = await copying;
    this.#check('push');
    const index = this.#numPushed;
    this.#numPushed += 1;
    try {
      this.#info = await this.#engine.request('push', raw);
    } catch (error) {
      this.#numPushed -= 1;
      throw raw.kind === 'file' ? withFrame(error, { index, name: raw.name }) : error;
    }
  }

  /**
   * Uses the trajectories of any tracker instead of tracking. If all frames of the trajectories are pushed too, before or
   * after, `run` computes masks too, from the flow and the denser trajectories of this session; without frames it ends
   * with the labels of these trajectories. A further call replaces them.
   */
  async setTrajectories(trajectories: TrajectoryInput): Promise<void> {
    this.#check('setTrajectories');
    this.#info = await this.#engine.request('setTrajectories', toRawTrajectories(trajectories));
  }

  /**
   * Runs all remaining work. `onProgress` is called for each stage; its `share` begins at 0 in each run. If `signal` aborts,
   * the promise rejects with its reason and the session keeps its state: the next `run` continues from there, to the same
   * result.
   */
  async run(options?: RunOptions): Promise<Result> {
    this.#check('run');
    return this.#process(options);
  }

  /** Number of corrections in force: those made and not undone. */
  get corrections() {
    return this.#info.corrections;
  }

  /**
   * Merges object `b` into object `a`; with `a` = 0 it becomes background. Like every correction this needs the masks of a
   * finished run, and returns a new result; earlier results do not change. Other labels keep their meaning and their
   * pixels.
   * @param a the label that stays, 0 to 255
   * @param b the label that goes, 1 to 255
   */
  async merge(a: number, b: number, options?: RunOptions): Promise<Result> {
    this.#check('merge');
    return this.#process(options, toMerge(a, b));
  }

  /**
   * Splits an object in two: into its clusters, or else where its motion and its extent are weakest. With `at`, the part at
   * that place gets a new label, the lowest free one; otherwise the smaller part does. `split(0, at)` makes an object of the
   * background at a place. Rejects with code `data` if nothing can be split.
   *
   * If `signal` aborts, the correction stays in force: `run` finishes it, `undo` undoes it.
   * @param label 0 to 255
   */
  async split(label: number, at?: Place, options?: RunOptions): Promise<Result> {
    this.#check('split');
    return this.#process(options, toSplit(label, at, this.#info));
  }

  /**
   * Joins everything under these strokes to one object. The objects that they largely cover get the lowest label of them;
   * anything else under the strokes, such as a part of an object that was labelled background, joins it there and along its
   * trajectories. Under the middle of a stroke the mask always has this label.
   * @param strokes 1 to 255, at least one over an object
   */
  async together(strokes: readonly Stroke[], options?: RunOptions): Promise<Result> {
    this.#check('together');
    return this.#process(options, toStrokes('together', strokes, this.#info));
  }

  /**
   * Makes each of these strokes an object of its own. Of strokes over one object, the one with the larger part keeps its
   * label, each other gets the lowest free label; a stroke that also covers background becomes background. Trajectories
   * between the strokes join the stroke that they are closest to in motion and place.
   * @param strokes 2 to 255
   */
  async apart(strokes: readonly Stroke[], options?: RunOptions): Promise<Result> {
    this.#check('apart');
    return this.#process(options, toStrokes('apart', strokes, this.#info));
  }

  /** Undoes the last correction: masks, objects and clusters are as before it. */
  async undo(options?: RunOptions): Promise<Result> {
    this.#check('undo');
    return this.#process(options, { kind: 'undo' });
  }

  /** Runs all remaining work, after a correction if there is one. */
  async #process(options?: RunOptions, correction?: RawCorrection): Promise<Result> {
    const { onProgress, signal } = checkRunOptions(options);
    signal?.throwIfAborted();

    const inner = new AbortController();
    const stop = (reason: unknown) => inner.abort(reason);
    this.#stopRun = stop;
    const onAbort = () => stop(signal?.reason);
    signal?.addEventListener('abort', onAbort);
    try {
      const report = this.#createReport(onProgress, stop);
      if (correction) await untilAborted(this.#apply(correction), inner.signal);
      const raw = await untilAborted(this.#engine.run(report, inner.signal), inner.signal);
      if (raw === null) throw new TraceCutError('closed', 'the session was closed');
      return new Result(raw, this.#createAsk());
    } finally {
      signal?.removeEventListener('abort', onAbort);
      this.#stopRun = undefined;
    }
  }

  /** Wraps the caller's `onProgress`: an error in it ends the run, which rejects with it. */
  #createReport(onProgress: RunOptions['onProgress'], fail: (error: unknown) => void): OnStep {
    const { numFrames } = this.#info;
    const without = this.#numPushed === 0 ? STAGES_OF_FRAMES : this.#isDense ? [] : STAGES_OF_MASKS;
    const meter = new RunMeter(new ClipWork(numFrames, numFrames, 0, false), without);
    let hasFailed = false;
    return (step) => {
      if (hasFailed || !onProgress) return;
      try {
        onProgress({ ...step, ...meter.countStep({ ...step, window: 0 }, numFrames, numFrames) });
      } catch (error) {
        hasFailed = true;
        fail(error);
      }
    };
  }

  async #apply(correction: RawCorrection) {
    this.#info = await this.#engine.request('correct', correction);
    this.#numCorrections += 1;
  }

  /** Returns the forward optical flow from frame `t` to `t + 1`, in input pixels, at the working size. */
  async flow(t: number): Promise<FlowField> {
    this.#check('flow');
    checkWholeNumber('param', 't', t, 0, Math.max(0, this.#info.numFrames - 2));
    return this.#engine.request('flow', t);
  }

  /** Returns the boundary probability of frame `t`, at the working size; computed at each call, also before the run. */
  async boundaries(t: number): Promise<BoundaryMap> {
    return this.#requestMap('boundaries', t);
  }

  /** Returns the Gabriel superpixels of frame `t`, at the working size. */
  async superpixels(t: number): Promise<Superpixels> {
    return this.#requestMap('superpixels', t);
  }

  /**
   * Returns the scene of frame `t` without the objects, at the working size; available once the masks of all frames are,
   * and computed at each call.
   */
  async background(t: number): Promise<Background> {
    return this.#requestMap('background', t);
  }

  /** Returns the saliency of each pixel of frame `t`, at the working size; available after that stage, computed at each call. */
  async saliencyMap(t: number): Promise<SaliencyMap> {
    return this.#requestMap('saliencyMap', t);
  }

  async #requestMap<N extends MapName>(name: N, ...place: Arguments<N>): Promise<Answer<N> & Grid> {
    this.#check(name);
    checkWholeNumber('param', 't', place[0], 0, Math.max(0, this.#info.numFrames - 1));
    return addScale(await this.#engine.request(name, ...place), this.#info.width, this.#info.height);
  }

  /** Returns a function for later requests of a result, valid while this session is open and holds the same clip. */
  #createAsk(): Ask {
    const [clipNumber, numCorrections] = [this.#clipNumber, this.#numCorrections];
    return async (name, ...args) => {
      const { noun, byLabels: ofLabels } = REQUESTS[name];
      if (this.#closed)
        throw new TraceCutError(
          'closed',
          `${noun} of a result come from its session, which is closed; request them before closing it`,
        );
      const change =
        clipNumber !== this.#clipNumber
          ? 'cleared'
          : ofLabels && numCorrections !== this.#numCorrections && 'corrected';
      if (change)
        throw new TraceCutError('state', `${noun} of a result come from its session, which was ${change} since`);
      this.#check(name);
      return this.#engine.request(name, ...args);
    };
  }

  /** Drops frames and results; parameters stay. The next clip may have another size. */
  async clear(): Promise<void> {
    this.#check('clear');
    this.#clipNumber += 1;
    this.#info = await this.#engine.request('clear');
    this.#numPushed = 0;
  }

  /** Frees the session's memory. A run under way rejects with code `closed`; closing twice is fine. */
  close() {
    if (this.#closed) return;
    this.#closed = true;
    droppedSessions?.unregister(this);
    this.#stopRun?.(new TraceCutError('closed', 'the session was closed'));
    this.#engine.close();
  }

  /** Same as `close`. */
  free() {
    this.close();
  }

  /** Closes the session at the end of `using session = await createSession()`, in engines that have `using`. */
  [Symbol.dispose]() {
    this.close();
  }

  #check(call: string) {
    if (this.#closed) throw new TraceCutError('closed', `${call} was called on a closed session; create a new one`);
    if (this.#stopRun)
      throw new TraceCutError('busy', `${call} was called while a run is under way; wait for it or abort it`);
  }
}

function checkRunOptions(options: RunOptions = {}): RunOptions {
  const { onProgress, signal } = checkOptions(options, ['onProgress', 'signal']);
  if (onProgress !== undefined && typeof onProgress !== 'function')
    throw illegal('param', 'onProgress', onProgress, 'a function');
  if (signal !== undefined && typeof signal?.throwIfAborted !== 'function')
    throw illegal('param', 'signal', signal, 'an AbortSignal');
  return options;
}
