/** What is asked for when a layer first looks at a frame. @module */

/** @typedef {import('./layer.js').View} View */
/** @typedef {import('./layer.js').Answer} Answer */

/**
 * Answers by frame, one question at a time: while the clip plays, frames in between are passed over.
 *
 * @template {keyof Answer} K
 * @template T
 */
export class Fetched {
  /**
   * @param {K} what
   * @param {(answer: Answer[K]) => T} made what is kept of an answer
   */
  constructor(what, made) {
    this.what = what;
    this.made = made;
    /** @type {Map<number, T>} */
    this.known = new Map();
    this.busy = false;
    this.run = 0;
  }

  /** Forgets everything, also what is on its way. */
  reset() {
    this.known.clear();
    this.busy = false;
    this.run += 1;
  }

  /**
   * @param {View} view is drawn again when the answer has come
   * @param {number} frame
   * @returns {T | undefined} undefined as long as it is on its way, and where nobody knows
   */
  get(view, frame) {
    const known = this.known.get(frame);
    const ask = /** @type {((frame: number) => Promise<Answer[K]>) | null} */ (view.answers[this.what]);
    if (known === undefined && !this.busy && ask) this.fetch(view, frame, ask);
    return known;
  }

  /**
   * @param {View} view
   * @param {number} frame
   * @param {(frame: number) => Promise<Answer[K]>} ask
   */
  async fetch(view, frame, ask) {
    const asked = this.run;
    this.busy = true;
    try {
      const answer = await ask(frame);
      if (asked === this.run) this.known.set(frame, this.made(answer));
    } catch (error) {
      // A session that was closed meanwhile answers nobody.
      if (asked === this.run) console.warn(`no ${this.what} of frame`, frame, error);
    } finally {
      if (asked === this.run) {
        this.busy = false;
        if (this.known.has(frame)) view.redraw();
      }
    }
  }
}
