// A clip window by window: what is found in one, and the driver that goes from one to the next.

import { TraceCutError, inFrame } from '../check/errors.js';
import { type Ask, REQUESTS } from '../session/requests.js';
import { Result, restored } from '../session/result.js';
import { FEWEST, isDamage } from './reader.js';
import type { Engine, Info, Progress, RawResult } from '../session/engine.js';
import type { RawFrame } from '../worker/frames.js';
import type { Pause } from '../worker/pause.js';

/**
 * One frame whose mask is settled: `index` counts the clip's frames, `t` those of the window; `labels` holds one byte
 * for each pixel.
 */
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
  settled: { from: number; to: number };
}

/**
 * What a window of a clip's frames gave: a `Result` whose frames are counted from the window's first, with labels that
 * mean the same object in every window of the shot.
 */
export class WindowResult extends Result {
  /** Number of this window, from 0. */
  readonly index: number;
  /** The clip that its frames were said to be of; null where nothing was said. */
  readonly clip: string | null;
  /** Number of the shot that it lies in, from 0: labels of one shot say nothing about another. */
  readonly shot: number;
  /** Which of the clip's frames its first one is. */
  readonly firstFrame: number;
  /** The time of each of its frames, in seconds. */
  readonly times: Float64Array<ArrayBuffer>;
  /** When the last of them ends, in seconds; null where nothing says. */
  readonly end: number | null;
  /**
   * The frames, `from <= t < to`, whose masks are settled by this window. Windows overlap; the masks of frames
   * outside of this range are better in the window before or after, which sees more of what goes on around them.
   */
  readonly settled: { from: number; to: number };
  /** Bytes of memory that the engine held at the end of this window. */
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
   * A window's result that was saved.
   * @param json as of `Result.fromJSON`
   */
  static fromJSON(json: string | object): WindowResult {
    const needed = ['trajectories', 'clusters', 'edgeTable', 'settled', 'firstFrame'];
    return restored(json, needed, (raw, ask, facts) => new WindowResult(raw, ask, facts));
  }

  /** The settled frames: over all windows, each frame of the clip once and in order. */
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
// A window is full when it has `window` frames and one more comes. It is run, then all but its last frames are dropped, and
// the new frame is the next; how many stay, and which frames each window settles, the engine says. It holds a frame back
// when that begins a new shot: then the shot ends with the window at hand, and the new one begins with nothing but that
// frame. A frame of another clip ends the window and its shot as well; the engine is cleared for it, so that nothing of
// one clip is in the next. Damage ends the clip with the frames before it.

/** `end` is when it ends, in seconds, where that is known; `clip` which of several it is of. */
export type ClipFrame = { raw: RawFrame; time: number; end?: number | null; clip?: string };

export interface DriverOptions {
  engine: Pick<Engine, 'request' | 'run'>;
  /** Null after the last. */
  nextFrame: () => Promise<ClipFrame | null>;
  /** How many frames `nextFrame` will still give, where that is known. */
  left: () => number | null;
  window: number;
  onStage: (progress: Progress, window: number) => void;
  /** Told how many frames the window has. */
  onFrame: (decoded: number, window: number) => void;
  /** Told what the clip ends with before its end, and how many frames come before. */
  onDamage: (error: TraceCutError, frames: number) => void;
  stop: AbortSignal;
  /** Halts the work between two frames, and between two steps of a window. */
  pause?: Pause;
}

export class Driver {
  #options;
  /** Read already, but not pushed. */
  #ahead: ClipFrame | null = null;
  /** Times of the frames that the engine holds in its window. */
  #times: number[] = [];
  /** When the last of them ends. */
  #end: number | null = null;
  /** The number of the window at hand. */
  #index = 0;
  /** Whether it has frames that no window before had. */
  #fresh = false;
  #ended = false;
  /** How many frames the engine was given. */
  #pushed = 0;
  /** Which of several clips it is. */
  #clip: string | undefined;
  /** The time of the frame that the engine holds back. */
  #held: number | null = null;
  /** Grows when the engine goes on: what an earlier window could be asked is gone. */
  #advances = 0;
  /** What the engine held after the last window. */
  info: Info | undefined;

  constructor(options: DriverOptions) {
    this.#options = options;
  }

  /** The next window's result; null after the last. */
  async next(): Promise<WindowResult | null> {
    if (this.#held !== null) await this.#beginShot(this.#held);
    if (this.#ahead) await this.#beginClip(this.#ahead.clip);
    await this.#fill();
    if (!this.#fresh) return null;
    return this.#ahead && this.#ahead.clip === this.#clip ? this.#fullWindow() : this.#lastWindow();
  }

  /** Pushes frames until the window is full and one more is there, a new shot or clip begins, or there are no more. */
  async #fill() {
    const { nextFrame, window, onFrame } = this.#options;
    while (!this.#ended && this.#held === null) {
      await this.#options.pause?.passed();
      this.#ahead = await nextFrame().catch((error) => this.#endBefore(error));
      if (!this.#ahead) this.#ended = true;
      else if (this.#times.length >= window || this.#isOfAnother(this.#ahead)) return;
      else {
        this.#clip = this.#ahead.clip;
        await this.#pushAhead();
        if (this.#held === null && !this.#ended) onFrame(this.#times.length, this.#index);
      }
    }
  }

  /** Ends the clip before damage, where the frames before it are enough to be segmented. */
  #endBefore(error: unknown) {
    if (!isDamage(error) || this.#pushed < FEWEST) throw error;
    this.#ended = true;
    error.frames = this.#pushed;
    this.#options.onDamage(error, this.#pushed);
    return null;
  }

  #isOfAnother({ clip }: ClipFrame) {
    return this.#times.length > 0 && clip !== this.#clip;
  }

  async #pushAhead() {
    const { raw, time, end = null } = this.#ahead!;
    this.#ahead = null;
    this.#end = end;
    const answer = await this.#options.engine
      .request('pushInShot', raw)
      .catch((error) => this.#endBefore(raw.kind === 'file' ? inFrame(error, raw) : error));
    if (!answer) return;
    this.#pushed += 1;
    this.#fresh = true;
    if (answer.held) this.#held = time;
    else this.#times.push(time);
  }

  /** The shot goes on, as far as is known: the masks of the last few frames are left to the next window. */
  async #fullWindow() {
    const { engine, left } = this.#options;
    const seen = await this.#run();
    const kept = await engine.request('shared', left() ?? undefined);
    await this.#advance(kept);
    this.#times = this.#times.slice(-kept);
    this.#fresh = false;
    await this.#pushAhead();
    return this.#result(seen, this.#held === null && this.#fresh ? kept : undefined);
  }

  /** The shot ends here. */
  async #lastWindow() {
    const seen = await this.#run();
    this.#fresh = this.#held !== null;
    return this.#result(seen, undefined);
  }

  async #beginShot(time: number) {
    await this.#advance(1);
    this.#times = [time];
    this.#held = null;
  }

  /** @param clip the one of the frame read already */
  async #beginClip(clip: string | undefined) {
    this.#advances += 1;
    await this.#options.engine.request('clear');
    this.#clip = clip;
    this.#times = [];
    await this.#pushAhead();
    this.#options.onFrame(1, this.#index);
  }

  #advance(overlap: number) {
    this.#advances += 1;
    return this.#options.engine.request('advance', overlap);
  }

  async #run() {
    const { engine, onStage, stop, pause } = this.#options;
    for (;;) {
      await pause?.passed();
      const raw = await engine.run((progress) => onStage(progress, this.#index), pause?.signal ?? stop);
      this.info = raw?.info;
      if (raw !== null) {
        const [times, end, clip] = [Float64Array.from(this.#times), this.#end, this.#clip ?? null];
        return { raw, ask: this.#asker(), times, end, clip };
      }
      if (stop.aborted || !pause) throw new TraceCutError('closed', 'the video segmentation was closed');
    }
  }

  /** @param kept how many frames the next window of the shot shares with it, if there is one */
  async #result(
    {
      raw,
      ask,
      ...seen
    }: { raw: RawResult; ask: Ask; times: Float64Array<ArrayBuffer>; end: number | null; clip: string | null },
    kept: number | undefined,
  ) {
    const place = await this.#options.engine.request('closeWindow', seen.times.length, kept);
    this.#index += 1;
    return new WindowResult(raw, ask, { ...place, ...seen });
  }

  /**
   * A window may be asked for more as long as the engine has not gone on, which it has by the time that any but the
   * last is seen.
   */
  #asker(): Ask {
    const { engine, stop } = this.#options;
    const advances = this.#advances;
    return async (name, ...args) => {
      if (advances !== this.#advances || stop.aborted) throw gone(REQUESTS[name].called);
      return engine.request(name, ...args);
    };
  }
}

function gone(what: string) {
  const until = 'only those of the last window are there, until the loop is left';
  return new TraceCutError(
    'state',
    `${what} of this window are gone, since the next is computed already (${until}); a session keeps them`,
  );
}
