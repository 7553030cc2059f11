// One run of the core over the frames of one clip.

import { createSession } from 'tracecut';

/**
 * Segments a clip in a session of its own, so that neither parameters nor errors of an earlier run matter.
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

/** Answers that are kept: a map of a large frame takes megabytes. */
const MAX_ANSWERS = 150;

/** A finished run: its result, and its session, which answers questions until it is closed. */
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

  /** Asks the result, or for the flow the session, about frame `t`; each question once. @param {string} name */
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
