/**
 * Coarse masks of a clip's first frames, to look at while the run goes on: a worker of their own makes them of the frames
 * that the run reads anyway. They change nothing in the run, and where they fail there are none.
 * @module
 */

import { VideoSegmentation, previewMasks } from './library.js';

/** @typedef {import('./library.js').VideoResult} VideoResult */

/** Every `STEP` frames one is taken, `TAKEN` of them in all: as the package does by itself. */
const STEP = 2;
const TAKEN = 8;

/** Frames from the first that is taken to the last. */
export const COVERED = STEP * (TAKEN - 1) + 1;

/** Pixels of all frames together from which on a run takes so long that it is worth a preview: about three seconds. */
const WORTH = 3.2e6;

/**
 * @param {import('./source.js').Source} source
 * @param {import('./source.js').Take} take
 * @returns {boolean} whether the masks of a run take so long that a preview comes well before them
 */
export function isWorth({ kind, width, height }, { frames, side }) {
  const reduced = Math.min(1, side / Math.max(width, height));
  // The masks of the first window are waited for.
  const waited = Math.min(frames, VideoSegmentation.usual.window);
  return kind !== 'still' && waited > COVERED && width * height * reduced ** 2 * waited >= WORTH;
}

export class Preview {
  /**
   * Begins at once: the worker is ready when the frames are.
   *
   * @param {import('./job.js').Options} options those of the run
   */
  constructor(options) {
    const { clip: { maxSide: _, ...clip } = {}, threads: __, ...others } = options;
    /** @type {VideoResult | null} */
    this.masks = null;
    /** @type {Map<number, Uint8Array>} Those that were looked at. */
    this.seen = new Map();
    /** Called when they are there. */
    this.onMasks = () => {};
    this.added = 0;
    this.life = new AbortController();
    /** @type {ReadableStreamDefaultController<ImageData> | undefined} */
    this.frames = undefined;
    const stream = new ReadableStream({ start: (controller) => void (this.frames = controller) });
    const { signal } = this.life;
    previewMasks(stream, { ...others, clip, step: STEP, maxFrames: TAKEN, signal }).then(
      (masks) => {
        if (signal.aborted) return;
        this.masks = masks;
        this.onMasks();
      },
      () => this.close(),
    );
  }

  /** @param {ImageData} frame the next of the clip */
  add(frame) {
    if (this.life.signal.aborted || this.added === COVERED) return;
    this.added += 1;
    try {
      this.frames?.enqueue(frame);
    } catch {
      // The package has stopped reading.
      this.close();
    }
  }

  /**
   * @param {number} frame
   * @returns {number} the last one up to it that has a mask
   */
  shownAt(frame) {
    return Math.min(COVERED - 1, frame - (frame % STEP));
  }

  /**
   * @param {number} frame
   * @returns {Uint8Array | null} what moves in `shownAt(frame)`, at the size of the frames: which of it belongs together
   *   is often not to be seen yet
   */
  labels(frame) {
    const at = this.shownAt(frame) / STEP;
    if (!this.masks || at >= this.masks.numFrames) return null;
    const labels = this.seen.get(at) ?? this.masks.labels(at).map((label) => Math.min(1, label));
    this.seen.set(at, labels);
    return labels;
  }

  /** Ends the work; nothing is told any more. */
  close() {
    this.onMasks = () => {};
    this.life.abort();
  }
}
