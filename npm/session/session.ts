// One clip at a time: `Session` checks what it is given, runs, aborts and corrects; an engine does the work.

import { TraceCutError, illegal, inFrame, wholeNumber } from '../check/errors.js';
import { type SessionOptions, splitOptions } from '../check/options.js';
import { type BoundaryMap, type Grid, type Superpixels, onGrid } from '../stages/image.js';
import { type FrameSource, toRawFrame } from '../worker/frames.js';
import { untilAborted } from '../worker/pause.js';
import { decoderLoader, openEngine } from '../worker/remote.js';
import { mergeOf, splitOf, strokesOf, toRawTrajectories } from './inputs.js';
import { type Answer, type Arguments, type Ask, type MapName, REQUESTS, type ResultLine } from './requests.js';
import { type Background, Result, type SaliencyMap } from './result.js';
import type { Engine, FlowField, Info, OnProgress } from './engine.js';
import type { Place, RawCorrection, Stroke, TrajectoryInput } from './inputs.js';

/** Opens a session. */
export async function createSession(options?: SessionOptions): Promise<Session> {
  const split = splitOptions(options);
  return new Session(await openEngine(split), decoderLoader(split.decoder), split.maxPixels);
}

const NOTHING: Info = {
  numFrames: 0,
  width: 0,
  height: 0,
  workingWidth: 0,
  workingHeight: 0,
  corrections: 0,
  memoryBytes: 0,
};

/** How a run or a correction reports and is stopped. */
export interface RunOptions {
  /** Hears of each stage. */
  onProgress?: OnProgress;
  /** Ends the work: the promise rejects with its reason, and the session keeps what it has. */
  signal?: AbortSignal;
}

/**
 * Closes the engines of sessions that were dropped without `close`: nothing else would end their workers. A run or a
 * push under way, and a result that may still ask, keep their session. Some engines, such as older workerd, never tell.
 */
const forgotten: FinalizationRegistry<Engine> | undefined =
  typeof FinalizationRegistry === 'undefined'
    ? undefined
    : /* @__PURE__ */ new FinalizationRegistry((engine) => engine.close());

/**
 * One clip on its way to labelled trajectories and masks. Made by `createSession`. Frames go in, `run` does the work,
 * results are plain arrays that stay when the session is closed; only superpixels, boundaries and saliency maps are
 * made and fetched when they are asked for.
 */
export class Session {
  #engine;
  #info = NOTHING;
  #closed = false;
  /** Grows when the session is cleared. */
  #clip = 0;
  /** Grows with each correction. */
  #corrected = 0;
  /** Ends the present run early. */
  #stopRun: ((reason: unknown) => void) | undefined;

  /** Frames that are on their way or there. */
  #pushed = 0;
  #loadDecoder;
  #maxPixels;
  /** Frames reach the engine in the order of the calls, however long each takes to copy. */
  #copied: Promise<unknown> = Promise.resolve();

  /** @param info what the engine holds already */
  constructor(
    engine: Engine,
    loadDecoder: () => Promise<WebAssembly.Module>,
    maxPixels?: number,
    info: Info = NOTHING,
  ) {
    this.#maxPixels = maxPixels;
    this.#engine = engine;
    this.#info = info;
    this.#pushed = info.numFrames;
    this.#loadDecoder = loadDecoder;
    forgotten?.register(this, engine, this);
  }

  /** Frames pushed so far, or of the outside trajectories' clip. */
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
    const before = this.#copied;
    const copying = toRawFrame(frame, this.#loadDecoder, this.#maxPixels);
    this.#copied = Promise.allSettled([before, copying]);
    await before;
    const raw = await copying;
    this.#check('push');
    const index = this.#pushed;
    this.#pushed += 1;
    try {
      this.#info = await this.#engine.request('push', raw);
    } catch (error) {
      this.#pushed -= 1;
      throw raw.kind === 'file' ? inFrame(error, { index, name: raw.name }) : error;
    }
  }

  /**
   * Uses the trajectories of any tracker in place of those that tracking would find. With frames pushed, before or
   * after, as many as the trajectories have, `run` makes masks too, by the flow and the denser trajectories of this
   * session; without frames it ends with the labels of these. Set again, they take the place of those before.
   */
  async setTrajectories(trajectories: TrajectoryInput): Promise<void> {
    this.#check('setTrajectories');
    this.#info = await this.#engine.request('setTrajectories', toRawTrajectories(trajectories));
  }

  /**
   * Does everything that is left to do. `onProgress` hears of each stage. When `signal` aborts, the promise rejects
   * with its reason and the session keeps what it has: the next `run` goes on from there, to the same result.
   */
  async run(options?: RunOptions): Promise<Result> {
    this.#check('run');
    return this.#work(options);
  }

  /** Number of corrections in force: those made and not undone. */
  get corrections() {
    return this.#info.corrections;
  }

  /**
   * Makes object `b` a part of object `a`; with `a` = 0 it becomes background. Like every correction it needs the masks
   * of a finished run, and gives a new result; earlier results stay as they are. Labels that it does not speak of keep
   * their meaning and their pixels.
   * @param a the label that stays, 0 to 255
   * @param b the label that goes, 1 to 255
   */
  async merge(a: number, b: number, options?: RunOptions): Promise<Result> {
    this.#check('merge');
    return this.#work(options, mergeOf(a, b));
  }

  /**
   * Parts an object in two: into the clusters that it consists of, or else where its motion and its extent are weakest.
   * With `at`, the part there gets a new label, the lowest that is free; otherwise the smaller part does. `split(0,
   * at)` makes an object of what is at a place of the background. Rejects with code `data` where there is nothing to
   * part.
   *
   * If `signal` aborts, the correction stays in force: `run` finishes it, `undo` takes it back.
   * @param label 0 to 255
   */
  async split(label: number, at?: Place, options?: RunOptions): Promise<Result> {
    this.#check('split');
    return this.#work(options, splitOf(label, at, this.#info));
  }

  /**
   * All that these strokes touch is one thing. The objects that they lie over to a good part become one, with the
   * lowest label; what else is under them, such as a part of an object that was taken for background, joins it there
   * and wherever its trajectories go. Under the middle of a stroke the mask has the label in any case.
   * @param strokes 1 to 255, at least one over an object
   */
  async together(strokes: readonly Stroke[], options?: RunOptions): Promise<Result> {
    this.#check('together');
    return this.#work(options, strokesOf('together', strokes, this.#info));
  }

  /**
   * Each of these strokes is a thing of its own. Of strokes over one object, that with the larger part keeps its label,
   * each other becomes a new object with the lowest label that is free; one that also lies over background is
   * background. Between the strokes, trajectories go with the stroke that they are bound to more closely by motion and
   * place.
   * @param strokes 2 to 255
   */
  async apart(strokes: readonly Stroke[], options?: RunOptions): Promise<Result> {
    this.#check('apart');
    return this.#work(options, strokesOf('apart', strokes, this.#info));
  }

  /** Takes the last correction back: masks, objects and clusters are again what they were before it. */
  async undo(options?: RunOptions): Promise<Result> {
    this.#check('undo');
    return this.#work(options, { kind: 'undo' });
  }

  /** Does everything that is left to do, after a correction if there is one. */
  async #work(options?: RunOptions, correction?: RawCorrection): Promise<Result> {
    const { onProgress, signal } = checkedRun(options);
    signal?.throwIfAborted();

    const inner = new AbortController();
    const stop = (reason: unknown) => inner.abort(reason);
    this.#stopRun = stop;
    const onAbort = () => stop(signal?.reason);
    signal?.addEventListener('abort', onAbort);
    try {
      const report = guardedReport(onProgress, stop);
      if (correction) await untilAborted(this.#apply(correction), inner.signal);
      const raw = await untilAborted(this.#engine.run(report, inner.signal), inner.signal);
      if (raw === null) throw new TraceCutError('closed', 'the session was closed');
      return new Result(raw, this.#asker());
    } finally {
      signal?.removeEventListener('abort', onAbort);
      this.#stopRun = undefined;
    }
  }

  async #apply(correction: RawCorrection) {
    this.#info = await this.#engine.request('correct', correction);
    this.#corrected += 1;
  }

  /** Forward optical flow from frame `t` to `t + 1`, in input pixels, at the size that frames are processed at. */
  async flow(t: number): Promise<FlowField> {
    this.#check('flow');
    wholeNumber('param', 't', t, 0, Math.max(0, this.#info.numFrames - 2));
    return this.#engine.request('flow', t);
  }

  /**
   * The boundary probability of frame `t`, at the size that frames are processed at; computed at each call, before the
   * run too.
   */
  async boundaries(t: number): Promise<BoundaryMap> {
    return this.#map('boundaries', t);
  }

  /** The Gabriel superpixels of frame `t`, at the size that frames are processed at. */
  async superpixels(t: number): Promise<Superpixels> {
    return this.#map('superpixels', t);
  }

  /**
   * The scene of frame `t` without the objects, at the size that frames are processed at; known once the masks of all
   * frames are, and made at each call.
   */
  async background(t: number): Promise<Background> {
    return this.#map('background', t);
  }

  /**
   * How salient each pixel of frame `t` is, at the size that frames are processed at; known once a run has got that
   * far, and computed at each call.
   */
  async saliencyMap(t: number): Promise<SaliencyMap> {
    return this.#map('saliencyMap', t);
  }

  async #map<N extends MapName>(name: N, ...place: Arguments<N>): Promise<Answer<N> & Grid> {
    this.#check(name);
    wholeNumber('param', 't', place[0], 0, Math.max(0, this.#info.numFrames - 1));
    return onGrid(await this.#engine.request(name, ...place), this.#info.width, this.#info.height);
  }

  /** How a result asks for more later, as long as this session is open and holds the same clip. */
  #asker(): Ask {
    const [clip, corrected] = [this.#clip, this.#corrected];
    return async (name, ...args) => {
      const { called, ofLabels } = REQUESTS[name];
      if (this.#closed)
        throw new TraceCutError(
          'closed',
          `${called} of a result come from its session, which is closed; ask before closing it`,
        );
      const change = clip !== this.#clip ? 'cleared' : ofLabels && corrected !== this.#corrected && 'corrected';
      if (change)
        throw new TraceCutError('state', `${called} of a result come from its session, which was ${change} since`);
      this.#check(name);
      return this.#engine.request(name, ...args);
    };
  }

  /** Drops frames and results; parameters stay. The next clip may have another size. */
  async clear(): Promise<void> {
    this.#check('clear');
    this.#clip += 1;
    this.#info = await this.#engine.request('clear');
    this.#pushed = 0;
  }

  /** Frees the session's memory. A run under way rejects with code `closed`; closing twice is fine. */
  close() {
    if (this.#closed) return;
    this.#closed = true;
    forgotten?.unregister(this);
    this.#stopRun?.(new TraceCutError('closed', 'the session was closed'));
    this.#engine.close();
  }

  /** As `close`. */
  free() {
    this.close();
  }

  /** `using session = await createSession()` closes it (an engine without `Symbol.dispose` has no `using` either). */
  [Symbol.dispose]() {
    this.close();
  }

  #check(call: string) {
    if (this.#closed) throw new TraceCutError('closed', `${call} was called on a closed session; create a new one`);
    if (this.#stopRun)
      throw new TraceCutError('busy', `${call} was called while a run is under way; wait for it or abort it`);
  }
}

function checkedRun(options: RunOptions = {}): RunOptions {
  if (typeof options !== 'object' || options === null)
    throw illegal('param', 'options', options, 'an object {onProgress, signal}');
  const { onProgress, signal } = options;
  if (onProgress !== undefined && typeof onProgress !== 'function')
    throw illegal('param', 'onProgress', onProgress, 'a function');
  if (signal !== undefined && typeof signal?.throwIfAborted !== 'function')
    throw illegal('param', 'signal', signal, 'an AbortSignal');
  return options;
}

/** `onProgress` is the caller's: an error in it ends the run and is what the run rejects with. */
function guardedReport(onProgress: OnProgress | undefined, fail: (error: unknown) => void): OnProgress {
  let over = false;
  return (progress) => {
    if (over) return;
    try {
      onProgress?.(progress);
    } catch (error) {
      over = true;
      fail(error);
    }
  };
}
