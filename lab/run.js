// One run of the core over the frames of one clip.

import { createSession } from 'tracecut';

/** @typedef {import('tracecut').Result} Result */
/** @typedef {import('tracecut').Session} Session */

/** The maps that a run computes when they are first asked for. */
const MAPS = {
  flow: (/** @type {Run} */ { session }, /** @type {number} */ t) => session.flow(t),
  saliency: (/** @type {Run} */ { result }, /** @type {number} */ t) => result.saliencyMap(t),
  boundaries: (/** @type {Run} */ { result }, /** @type {number} */ t) => result.boundaries(t),
  superpixels: (/** @type {Run} */ { result }, /** @type {number} */ t) => result.superpixels(t),
  background: (/** @type {Run} */ { result }, /** @type {number} */ t) => result.background(t),
  confidence: (/** @type {Run} */ { result }, /** @type {number} */ t) => result.confidence(t),
};

/**
 * Segments a clip in a session of its own, so that neither the parameters nor an error of an earlier run matter.
 * @param {import('./clip.js').Clip} clip
 * @param {import('tracecut').SessionOptions} options parameters that differ from the defaults
 * @param {object} report
 * @param {AbortSignal} report.signal ends the run
 * @param {(frame: import('./clip.js').Frame, t: number) => void} report.onFrame called for each frame that goes in
 * @param {(progress: import('tracecut').Progress) => void} report.onProgress
 * @returns {Promise<Run>}
 */
export async function segment(clip, options, { signal, onFrame, onProgress }) {
  const session = await createSession(options);
  try {
    for await (const frame of clip.decode(signal)) {
      signal.throwIfAborted();
      onFrame(frame, session.numFrames);
      await session.push(frame.canvas);
    }
    return new Run(session, await session.run({ signal, onProgress }), options);
  } catch (error) {
    session.close();
    throw error;
  }
}

/** A finished run: its result, and its session, which answers questions until it is closed. */
export class Run {
  /** @type {Map<string, Promise<any>>} */
  #maps = new Map();

  /**
   * @param {Session} session
   * @param {Result} result
   * @param {import('tracecut').SessionOptions} options
   */
  constructor(session, result, options) {
    this.session = session;
    this.result = result;
    this.options = options;
  }

  /**
   * Computes a map of frame `t`, once.
   * @template {keyof typeof MAPS} N
   * @param {N} name
   * @param {number} t
   * @returns {ReturnType<(typeof MAPS)[N]>}
   */
  map(name, t) {
    const key = `${name} ${t}`;
    const known = this.#maps.get(key) ?? MAPS[name](this, t);
    this.#maps.set(key, known);
    return /** @type {ReturnType<(typeof MAPS)[N]>} */ (known);
  }

  close() {
    this.session.close();
  }
}
