// Coarse masks of a clip's first frames, to look at while the run goes on: a worker of their own makes them of the frames
// that the run reads anyway. They change nothing in the run, and where they fail there are none.

import { type SessionOptions, type VideoResult, VideoSegmentation, previewMasks } from './library.js';
import type { Source, Take } from './source.js';

/** Every `STEP` frames one is taken, `TAKEN` of them in all: as the package does by itself. */
const STEP = 2;
const TAKEN = 8;

/** Frames from the first that is taken to the last. */
export const COVERED = STEP * (TAKEN - 1) + 1;

/** Pixels of all frames together from which on a run takes so long that it is worth a preview: about three seconds. */
const WORTH = 3.2e6;

/** Returns whether the masks of a run take so long that a preview comes well before them. */
export function isWorth({ kind, width, height }: Source, { frames, side }: Take): boolean {
  const reduced = Math.min(1, side / Math.max(width, height));
  // The masks of the first window are waited for.
  const waited = Math.min(frames, VideoSegmentation.defaults.window);
  return kind !== 'still' && waited > COVERED && width * height * reduced ** 2 * waited >= WORTH;
}

export class Preview {
  masks: VideoResult | null;
  seen: Map<number, Uint8Array>;
  onMasks: () => void;
  added: number;
  life: AbortController;
  frames: ReadableStreamDefaultController<ImageData> | undefined;

  /** Begins at once: the worker is ready when the frames are. */
  constructor(options: SessionOptions) {
    const { clip: { maxSide: _, ...clip } = {}, threads: __, ...others } = options;
    this.masks = null;
    this.seen = new Map();
    this.onMasks = () => {};
    this.added = 0;
    this.life = new AbortController();
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

  add(frame: ImageData) {
    if (this.life.signal.aborted || this.added === COVERED) return;
    this.added += 1;
    try {
      this.frames?.enqueue(frame);
    } catch {
      // The package has stopped reading.
      this.close();
    }
  }

  /** Returns the last frame up to this one that has a mask. */
  shownAt(frame: number): number {
    return Math.min(COVERED - 1, frame - (frame % STEP));
  }

  /**
   * @returns what moves in `shownAt(frame)`, at the size of the frames: which of it belongs together is often not to
   *   be seen yet
   */
  labels(frame: number): Uint8Array | null {
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
