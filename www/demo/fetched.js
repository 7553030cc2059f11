/** What the session is asked for when a layer first looks at a frame. @module */

/** @typedef {import('./layer.js').View} View */

/**
 * Answers by frame, one question at a time: while the clip plays, frames in between are passed over.
 *
 * @template T
 */
export class Fetched {
  /**
   * @param {string} what for the console, when it fails
   * @param {(view: View, frame: number) => Promise<T>} ask
   */
  constructor(what, ask) {
    this.what = what;
    this.ask = ask;
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
   * @returns {T | undefined} undefined as long as it is on its way
   */
  get(view, frame) {
    const known = this.known.get(frame);
    if (known === undefined && !this.busy) this.fetch(view, frame);
    return known;
  }

  /**
   * @param {View} view
   * @param {number} frame
   */
  async fetch(view, frame) {
    const asked = this.run;
    this.busy = true;
    try {
      const answer = await this.ask(view, frame);
      if (asked === this.run) this.known.set(frame, answer);
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
