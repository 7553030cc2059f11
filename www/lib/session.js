import { TraceCutError, illegal } from './errors.js';
import { createLocalEngine } from './engine.js';
import { toRawFrame } from './frames.js';
import { splitOptions, wholeNumber } from './options.js';
import { createRemoteEngine } from './remote.js';
import { Result } from './result.js';
import { toRawTrajectories } from './trajectories.js';

/**
 * What differs between browsers and Node.
 * @typedef {object} Platform
 * @property {(source?: import('./options.js').WasmSource) => Promise<WebAssembly.Module>} loadModule
 * @property {(() => Worker) | undefined} startWorker
 */

/**
 * @param {import('./options.js').SessionOptions | undefined} options
 * @param {Platform} platform
 */
export async function openSession(options, platform) {
  const { wasm, worker, parameters } = splitOptions(options);
  if (worker && !platform.startWorker) {
    throw new TraceCutError('unsupported', 'worker = true (expected false or nothing: this engine has no module workers; the session runs in-process)');
  }
  const module = await platform.loadModule(wasm);
  const engine =
    platform.startWorker && worker !== false
      ? await createRemoteEngine(platform.startWorker(), module, parameters)
      : await createLocalEngine(module, parameters);
  return new Session(engine);
}

/** @type {import('./engine.js').Info} */
const NOTHING = { numFrames: 0, width: 0, height: 0, workingWidth: 0, workingHeight: 0 };

/**
 * One clip on its way to labelled trajectories. Made by `createSession`. Frames go in, `run` does the work, results are plain
 * arrays that stay when the session is closed.
 */
export class Session {
  #engine;
  #info = NOTHING;
  #closed = false;
  /** @type {((reason: unknown) => void) | undefined} Ends the present run early. */
  #stopRun;

  /** @param {import('./engine.js').Engine} engine */
  constructor(engine) {
    this.#engine = engine;
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

  /**
   * Adds the next frame. All frames of a session have one size.
   * @param {import('./frames.js').FrameSource} frame
   * @returns {Promise<void>}
   */
  async push(frame) {
    this.#check('push');
    const raw = await toRawFrame(frame);
    this.#check('push');
    this.#info = await this.#engine.push(raw);
  }

  /**
   * Uses the trajectories of any tracker in place of frames, flow and tracking.
   * @param {import('./trajectories.js').TrajectoryInput} trajectories
   * @returns {Promise<void>}
   */
  async setTrajectories(trajectories) {
    this.#check('setTrajectories');
    this.#info = await this.#engine.setTrajectories(toRawTrajectories(trajectories));
  }

  /**
   * Does everything that is left to do. `onProgress` hears of each stage. When `signal` aborts, the promise rejects with its
   * reason and the session keeps what it has: the next `run` goes on from there, to the same result.
   * @param {{onProgress?: (progress: import('./engine.js').Progress) => void, signal?: AbortSignal}} [options]
   * @returns {Promise<Result>}
   */
  async run({ onProgress, signal } = {}) {
    this.#check('run');
    if (onProgress !== undefined && typeof onProgress !== 'function') throw illegal('param', 'onProgress', onProgress, 'a function');
    if (signal !== undefined && typeof signal?.addEventListener !== 'function') throw illegal('param', 'signal', signal, 'an AbortSignal');
    signal?.throwIfAborted();

    const inner = new AbortController();
    /** @type {Promise<never>} */
    const stopped = new Promise((_, reject) => {
      this.#stopRun = (reason) => {
        inner.abort();
        reject(reason);
      };
    });
    const stop = this.#stopRun;
    const onAbort = () => stop?.(signal?.reason);
    signal?.addEventListener('abort', onAbort);
    try {
      const report = guardedReport(onProgress, (error) => stop?.(error));
      const raw = await Promise.race([this.#engine.run(report, inner.signal), stopped]);
      if (raw === null) throw new TraceCutError('closed', 'the session was closed');
      return new Result(raw);
    } finally {
      signal?.removeEventListener('abort', onAbort);
      this.#stopRun = undefined;
    }
  }

  /**
   * Forward optical flow from frame `t` to `t + 1`, in input pixels, at the size that frames are processed at.
   * @param {number} t
   * @returns {Promise<import('./engine.js').FlowField>}
   */
  async flow(t) {
    this.#check('flow');
    wholeNumber('param', 't', t, 0, Math.max(0, this.#info.numFrames - 2));
    return this.#engine.flow(t);
  }

  /**
   * Drops frames and results; parameters stay. The next clip may have another size.
   * @returns {Promise<void>}
   */
  async clear() {
    this.#check('clear');
    this.#info = await this.#engine.clear();
  }

  /** Frees the session's memory. A run under way rejects with code `closed`; closing twice is fine. */
  close() {
    if (this.#closed) return;
    this.#closed = true;
    this.#stopRun?.(new TraceCutError('closed', 'the session was closed'));
    this.#engine.close();
  }

  /** `using session = await createSession()` closes it (an engine without `Symbol.dispose` has no `using` either). */
  [Symbol.dispose]() {
    this.close();
  }

  /** @param {string} call */
  #check(call) {
    if (this.#closed) throw new TraceCutError('closed', `${call} was called on a closed session; create a new one`);
    if (this.#stopRun) throw new TraceCutError('busy', `${call} was called while a run is under way; wait for it or abort it`);
  }
}

/**
 * `onProgress` is the caller's: an error in it ends the run and is what the run rejects with.
 * @param {((progress: import('./engine.js').Progress) => void) | undefined} onProgress
 * @param {(error: unknown) => void} fail
 * @returns {(progress: import('./engine.js').Progress) => void}
 */
function guardedReport(onProgress, fail) {
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
