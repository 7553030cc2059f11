// One run of the core over the frames of one clip.

import { createSession } from 'tracecut';

/**
 * Segments a clip in a new session, so that parameters and errors of earlier runs have no effect.
 * @param {import('./clip.js').Clip} clip
 * @param {import('tracecut').SessionOptions} options
 * @param {{signal: AbortSignal, onFrame: (t: number) => void, onProgress: (progress: import('tracecut').Progress) =>
 *   void}} report
 */
export async function segment(clip, options, { signal, onFrame, onProgress }) {
  const session = await createSession(options);
  try {
    for await (const { canvas } of clip.decode(signal)) {
      signal.throwIfAborted();
      onFrame(session.numFrames);
      await session.push(canvas);
    }
    return new Run(session, await session.run({ signal, onProgress }), options);
  } catch (error) {
    session.close();
    throw error;
  }
}

/** Maximum number of cached answers: a map of a large frame takes megabytes. */
const MAX_ANSWERS = 150;

/** A finished run: its result and its session, which answers queries until it is closed. */
export class Run {
  #answers = new Map();

  /**
   * @param {import('tracecut').Session} session
   * @param {import('tracecut').Result} result
   * @param {import('tracecut').SessionOptions} options
   */
  constructor(session, result, options) {
    this.session = session;
    this.result = result;
    this.options = options;
  }

  /** Queries the result, or the session for the flow, about frame `t`; answers are cached. @param {string} name */
  ask(name, t = 0) {
    const key = `${name} ${t}`;
    if (!this.#answers.has(key)) this.#answers.set(key, name === 'flow' ? this.session.flow(t) : this.result[name](t));
    if (this.#answers.size > MAX_ANSWERS) this.#answers.delete(this.#answers.keys().next().value);
    return this.#answers.get(key);
  }

  close() {
    this.session.close();
  }
}
