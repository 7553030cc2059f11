// Runs a clip window by window.
//
//   frames   0 ......................... 49 50 ...                         89
//   window 0 [============================]          settles 0..45
//   window 1                         [40 ============================ 89]     settles 45..
//
// A window is full when it has `window` frames and one more comes. It is run, then all but its last `overlap` frames are dropped, and the
// new frame is the next. The engine holds a frame back when it begins a new shot: then the shot ends with the window at hand, and the new
// one begins with nothing but that frame.

import { TraceCutError } from '../errors.js';
import { WindowResult } from './window.js';

/** @typedef {import('../frames.js').RawFrame} RawFrame */
/** @typedef {{raw: RawFrame, time: number}} ClipFrame */

/**
 * @typedef {object} DriverOptions
 * @property {Pick<import('../engine.js').Engine, 'pushInShot' | 'advance' | 'run'>} engine
 * @property {() => Promise<ClipFrame | null>} nextFrame null after the last
 * @property {number} window
 * @property {number} overlap
 * @property {(progress: import('../engine.js').Progress, window: number) => void} onStage
 * @property {(decoded: number, window: number) => void} onFrame told how many frames the window has
 * @property {AbortSignal} stop
 */

export class Driver {
  #options;
  /** @type {ClipFrame | null} Read already, but not pushed. */
  #ahead = null;
  /** @type {number[]} Times of the frames that the engine holds in its window. */
  #times = [];
  /** The clip's number of the window's first frame. */
  #first = 0;
  /** Frames of the window that an earlier one settled. */
  #settled = 0;
  #index = 0;
  #shot = 0;
  #ended = false;
  /** @type {number | null} The time of the frame that the engine holds back. */
  #held = null;

  /** @param {DriverOptions} options */
  constructor(options) {
    this.#options = options;
  }

  /**
   * The next window's result; null after the last.
   * @returns {Promise<WindowResult | null>}
   */
  async next() {
    if (this.#held !== null) await this.#beginShot(this.#held);
    await this.#fill();
    if (this.#times.length === this.#settled) return null;
    return this.#ahead ? this.#fullWindow() : this.#lastWindow();
  }

  /** Pushes frames until the window is full and one more is there, a new shot begins, or there are no more. */
  async #fill() {
    const { nextFrame, window, onFrame } = this.#options;
    while (!this.#ended && this.#held === null) {
      this.#ahead = await nextFrame();
      if (!this.#ahead) this.#ended = true;
      else if (this.#times.length >= window) return;
      else {
        await this.#pushAhead();
        if (this.#held === null) onFrame(this.#times.length, this.#index);
      }
    }
  }

  async #pushAhead() {
    const { raw, time } = /** @type {ClipFrame} */ (this.#ahead);
    this.#ahead = null;
    const { held } = await this.#options.engine.pushInShot(raw);
    if (held) this.#held = time;
    else this.#times.push(time);
  }

  /** The shot goes on, as far as is known: the masks of the last few frames are left to the next window. */
  async #fullWindow() {
    const raw = await this.#run();
    const facts = this.#facts();
    const kept = Math.min(this.#options.overlap, this.#times.length - 1);
    await this.#options.engine.advance(kept);
    this.#first += this.#times.length - kept;
    this.#times = this.#times.slice(-kept);
    this.#settled = Math.floor(kept / 2);
    await this.#pushAhead();
    if (this.#held !== null) this.#settled = kept;
    else facts.settled.to -= kept - this.#settled;
    return this.#result(raw, facts);
  }

  /** The shot ends here. */
  async #lastWindow() {
    const raw = await this.#run();
    const facts = this.#facts();
    this.#settled = this.#times.length;
    return this.#result(raw, facts);
  }

  /** @param {number} time of the frame held back */
  async #beginShot(time) {
    await this.#options.engine.advance(this.#options.overlap);
    this.#first += this.#times.length;
    this.#times = [time];
    this.#held = null;
    this.#settled = 0;
    this.#shot += 1;
  }

  async #run() {
    const { engine, onStage, stop } = this.#options;
    const raw = await engine.run((progress) => onStage(progress, this.#index), stop);
    if (raw === null) throw new TraceCutError('closed', 'the video segmentation was closed');
    return raw;
  }

  #facts() {
    const settled = { from: this.#settled, to: this.#times.length };
    return { shot: this.#shot, firstFrame: this.#first, times: Float64Array.from(this.#times), settled };
  }

  /**
   * @param {import('../engine.js').RawResult} raw
   * @param {Omit<import('./window.js').WindowFacts, 'index'>} facts
   */
  #result(raw, facts) {
    const index = this.#index;
    this.#index += 1;
    return new WindowResult(raw, GONE, { index, ...facts });
  }
}

/** @param {string} what */
const gone = (what) => async () => {
  throw new TraceCutError('state', `${what} of a window are gone when its result comes: the next one is computed already; a session has them`);
};

/** @type {import('../result.js').Lookups} */
const GONE = { boundaries: gone('boundaries'), superpixels: gone('superpixels'), saliencyMap: gone('saliency maps') };
