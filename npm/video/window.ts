// The result of a window of a clip, and the driver that runs window after window.

import { TraceCutError, withFrame } from '../check/errors.js';
import { type Ask, REQUESTS } from '../session/requests.js';
import { type FrameRange, Result, restoreResult } from '../session/result.js';
import { MIN_FRAMES, isDamage } from './reader.js';
import type { Engine, RawResult, SessionInfo, StageStep } from '../session/engine.js';
import type { RawFrame } from '../worker/frames.js';
import type { Pause } from '../worker/pause.js';

/** A frame whose mask is settled: `index` counts the clip's frames, `t` the window's; `labels` has one byte for each pixel. */
export type SettledFrame = {
  readonly index: number;
  readonly t: number;
  readonly time: number;
  readonly labels: Uint8Array<ArrayBuffer>;
};

export interface WindowFacts {
  index: number;
  clip?: string | null;
  shot: number;
  firstFrame: number;
  times: Float64Array<ArrayBuffer>;
  end: number | null;
  settled: FrameRange;
}

/**
 * The result of a window: a `Result` whose frames are counted from the window's first, with labels that mean the same
 * object in every window of the shot.
 */
export class WindowResult extends Result {
  /** Number of this window, from 0. */
  readonly index: number;
  /** Name of the clip of its frames; null if none was given. */
  readonly clip: string | null;
  /** Number of its shot, from 0; labels of different shots are unrelated. */
  readonly shot: number;
  /** Number of its first frame in the clip. */
  readonly firstFrame: number;
  /** The time of each of its frames, in seconds. */
  readonly times: Float64Array<ArrayBuffer>;
  /** Time at which its last frame ends, in seconds; null if unknown. */
  readonly end: number | null;
  /**
   * The frames, `from <= t < to`, whose masks this window settles. Windows overlap; the masks of frames outside of this range
   * are better in the window before or after, which sees more of the frames around them.
   */
  readonly settled: FrameRange;
  /** Memory of the engine at the end of this window, in bytes. */
  readonly memoryBytes: number;

  constructor(raw: RawResult, ask: Ask, facts: WindowFacts) {
    super(raw, ask);
    this.index = facts.index;
    this.clip = facts.clip ?? null;
    this.shot = facts.shot;
    this.firstFrame = facts.firstFrame;
    this.times = facts.times;
    this.end = facts.end;
    this.settled = facts.settled;
    this.memoryBytes = raw.info.memoryBytes;
  }

  /**
   * Restores a saved result of a window.
   * @param json as for `Result.fromJSON`
   */
  static fromJSON(json: string | object): WindowResult {
    const needed = ['trajectories', 'clusters', 'edgeTable', 'settled', 'firstFrame'];
    return restoreResult(json, needed, (raw, ask, facts) => new WindowResult(raw, ask, facts));
  }

  /** Yields the settled frames: over all windows, each frame of the clip once and in order. */
  *frames(): Generator<SettledFrame, void, undefined> {
    for (let t = this.settled.from; t < this.settled.to; t += 1) {
      yield { index: this.firstFrame + t, t, time: this.times[t]!, labels: this.labels(t) };
    }
  }
}

// Runs a clip window by window.
//
//   frames   0 ......................... 49 50 ...                         89
//   window 0 [============================]          settles 0..45
//   window 1                         [40 ============================ 89]     settles 45..
//
// A window is full when it has `window` frames and one more arrives. It is run, all but its last frames are dropped, and
// the new frame follows them; the engine decides how many stay, and which frames each window settles. It holds a frame back
// if that begins a new shot: then the shot ends with the present window, and the new one begins with that frame alone. A
// frame of another clip also ends the window and its shot; the engine is cleared, so that clips do not affect each other.
// Damage ends the clip with the frames before it.

/** A frame; `end` is the time at which it ends, in seconds, if known; `clip` names its clip if there are several. */
export type ClipFrame = { raw: RawFrame; time: number; end?: number | null; clip?: string };

export interface DriverOptions {
  engine: Pick<Engine, 'request' | 'run'>;
  /** Returns the next frame, null after the last. */
  nextFrame: () => Promise<ClipFrame | null>;
  /** Returns the number of frames that `nextFrame` will still return, if known. */
  countRemaining: () => number | null;
  window: number;
  onStage: (step: StageStep, window: number) => void;
  /** Called with the number of frames in the window. */
  onFrame: (decoded: number, window: number) => void;
  /** Called with the error that ends the clip early, and the number of frames before it. */
  onDamage: (error: TraceCutError, frames: number) => void;
  stop: AbortSignal;
  /** Halts the work between two frames, and between two steps of a window. */
  pause?: Pause;
}

export class Driver {
  #options;
  /** Read, but not pushed yet. */
  #nextFrame: ClipFrame | null = null;
  /** Times of the frames in the engine's window. */
  #times: number[] = [];
  /** Time at which the last of them ends. */
  #end: number | null = null;
  /** Number of the present window. */
  #index = 0;
  /** True if it has frames that no earlier window had. */
  #hasNewFrames = false;
  #hasEnded = false;
  /** Number of frames pushed. */
  #numPushed = 0;
  /** Name of the present clip. */
  #clip: string | undefined;
  /** Time of the frame that the engine holds back. */
  #heldTime: number | null = null;
  /** Increased when the engine advances, after which it cannot answer requests of earlier windows. */
  #numAdvances = 0;
  /** State of the engine after the last window. */
  info: SessionInfo | undefined;

  constructor(options: DriverOptions) {
    this.#options = options;
  }

  /** Returns the next window's result; null after the last. */
  async next(): Promise<WindowResult | null> {
    if (this.#heldTime !== null) await this.#beginShot(this.#heldTime);
    if (this.#nextFrame) await this.#beginClip(this.#nextFrame.clip);
    await this.#fill();
    if (!this.#hasNewFrames) return null;
    return this.#nextFrame && this.#nextFrame.clip === this.#clip ? this.#runFullWindow() : this.#runLastWindow();
  }

  /** Pushes frames until the window is full and one more arrives, a new shot or clip begins, or there are no more. */
  async #fill() {
    const { nextFrame, window, onFrame } = this.#options;
    while (!this.#hasEnded && this.#heldTime === null) {
      await this.#options.pause?.wait();
      this.#nextFrame = await nextFrame().catch((error) => this.#endBefore(error));
      if (!this.#nextFrame) this.#hasEnded = true;
      else if (this.#times.length >= window || this.#isOfOtherClip(this.#nextFrame)) return;
      else {
        this.#clip = this.#nextFrame.clip;
        await this.#pushNext();
        if (this.#heldTime === null && !this.#hasEnded) onFrame(this.#times.length, this.#index);
      }
    }
  }

  /** Ends the clip before damage, if it has enough frames to be segmented. */
  #endBefore(error: unknown) {
    if (!isDamage(error) || this.#numPushed < MIN_FRAMES) throw error;
    this.#hasEnded = true;
    error.frames = this.#numPushed;
    this.#options.onDamage(error, this.#numPushed);
    return null;
  }

  #isOfOtherClip({ clip }: ClipFrame) {
    return this.#times.length > 0 && clip !== this.#clip;
  }

  async #pushNext() {
    const { raw, time, end = null } = this.#nextFrame!;
    this.#nextFrame = null;
    this.#end = end;
    const answer = await this.#options.engine
      .request('pushInShot', raw)
      .catch((error) => this.#endBefore(raw.kind === 'file' ? withFrame(error, raw) : error));
    if (!answer) return;
    this.#numPushed += 1;
    this.#hasNewFrames = true;
    if (answer.held) this.#heldTime = time;
    else this.#times.push(time);
  }

  /** Runs a window whose shot continues, as far as known: the next window settles its last few frames. */
  async #runFullWindow() {
    const { engine, countRemaining: left } = this.#options;
    const output = await this.#run();
    const numShared = await engine.request('shared', left() ?? undefined);
    await this.#advance(numShared);
    this.#times = this.#times.slice(-numShared);
    this.#hasNewFrames = false;
    await this.#pushNext();
    return this.#createResult(output, this.#heldTime === null && this.#hasNewFrames ? numShared : undefined);
  }

  /** Runs the last window of a shot. */
  async #runLastWindow() {
    const output = await this.#run();
    this.#hasNewFrames = this.#heldTime !== null;
    return this.#createResult(output, undefined);
  }

  async #beginShot(time: number) {
    await this.#advance(1);
    this.#times = [time];
    this.#heldTime = null;
  }

  /** @param clip name of the clip of the next frame */
  async #beginClip(clip: string | undefined) {
    this.#numAdvances += 1;
    await this.#options.engine.request('clear');
    this.#clip = clip;
    this.#times = [];
    await this.#pushNext();
    this.#options.onFrame(1, this.#index);
  }

  #advance(overlap: number) {
    this.#numAdvances += 1;
    return this.#options.engine.request('advance', overlap);
  }

  async #run() {
    const { engine, onStage, stop, pause } = this.#options;
    for (;;) {
      await pause?.wait();
      const raw = await engine.run((progress) => onStage(progress, this.#index), pause?.signal ?? stop);
      this.info = raw?.info;
      if (raw !== null) {
        const [times, end, clip] = [Float64Array.from(this.#times), this.#end, this.#clip ?? null];
        return { raw, ask: this.#createAsk(), times, end, clip };
      }
      if (stop.aborted || !pause) throw new TraceCutError('closed', 'the video segmentation was closed');
    }
  }

  /** @param numShared number of frames shared with the next window of the shot, if there is one */
  async #createResult(
    {
      raw,
      ask,
      ...facts
    }: { raw: RawResult; ask: Ask; times: Float64Array<ArrayBuffer>; end: number | null; clip: string | null },
    numShared: number | undefined,
  ) {
    const place = await this.#options.engine.request('closeWindow', facts.times.length, numShared);
    this.#index += 1;
    return new WindowResult(raw, ask, { ...place, ...facts });
  }

  /** Returns a function for requests of a window, valid until the engine advances: for all but the last window it is too late. */
  #createAsk(): Ask {
    const { engine, stop } = this.#options;
    const numAdvances = this.#numAdvances;
    return async (name, ...args) => {
      if (numAdvances !== this.#numAdvances || stop.aborted) throw createGoneError(REQUESTS[name].noun);
      return engine.request(name, ...args);
    };
  }
}

function createGoneError(name: string) {
  const reason = 'only the last window has them, until the loop ends';
  return new TraceCutError(
    'state',
    `${name} of this window are gone: the next one is being computed (${reason}); a session keeps them`,
  );
}
