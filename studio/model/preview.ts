// Coarse masks of a clip's first frames, to look at while the run goes on: a worker of their own makes them of the frames
// that the run reads anyway. They change nothing in the run, and where they fail there are none.

import { type SessionOptions, type VideoResult, VideoSegmentation, previewMasks } from './library.js';
import type { Source, Trim } from './source.js';

/** Every `STEP` frames one is taken, `TAKEN` of them in all: as the package does by itself. */
const FRAME_STEP = 2;
const MAX_FRAMES = 8;

/** Frames from the first that is taken to the last. */
export const PREVIEW_FRAMES = FRAME_STEP * (MAX_FRAMES - 1) + 1;

/** Pixels of all frames together from which on a run takes so long that it is worth a preview: about three seconds. */
const MIN_CLIP_PIXELS = 3.2e6;

/** Returns whether the masks of a run take so long that a preview comes well before them. */
export function needsPreview({ kind, width, height }: Source, { frames, side }: Trim): boolean {
  const scale = Math.min(1, side / Math.max(width, height));
  // The masks of the first window are waited for.
  const frameCount = Math.min(frames, VideoSegmentation.usual.window);
  return kind !== 'still' && frameCount > PREVIEW_FRAMES && width * height * scale ** 2 * frameCount >= MIN_CLIP_PIXELS;
}

export class Preview {
  masks: VideoResult | null;
  labelsByFrame: Map<number, Uint8Array>;
  onMasks: () => void;
  addedCount: number;
  abort: AbortController;
  frames: ReadableStreamDefaultController<ImageData> | undefined;

  /** Begins at once: the worker is ready when the frames are. */
  constructor(options: SessionOptions) {
    const { clip: { maxSide: _, ...clip } = {}, threads: __, ...others } = options;
    this.masks = null;
    this.labelsByFrame = new Map();
    this.onMasks = () => {};
    this.addedCount = 0;
    this.abort = new AbortController();
    this.frames = undefined;
    const stream = new ReadableStream({ start: (controller) => void (this.frames = controller) });
    const { signal } = this.abort;
    previewMasks(stream, { ...others, clip, step: FRAME_STEP, maxFrames: MAX_FRAMES, signal }).then(
      (masks) => {
        if (signal.aborted) return;
        this.masks = masks;
        this.onMasks();
      },
      () => this.close(),
    );
  }

  add(frame: ImageData) {
    if (this.abort.signal.aborted || this.addedCount === PREVIEW_FRAMES) return;
    this.addedCount += 1;
    try {
      this.frames?.enqueue(frame);
    } catch {
      // The package has stopped reading.
      this.close();
    }
  }

  /** Returns the last frame up to this one that has a mask. */
  maskedFrame(frame: number): number {
    return Math.min(PREVIEW_FRAMES - 1, frame - (frame % FRAME_STEP));
  }

  /**
   * @returns what moves in `shownAt(frame)`, at the size of the frames: which of it belongs together is often not to
   *   be seen yet
   */
  labels(frame: number): Uint8Array | null {
    const at = this.maskedFrame(frame) / FRAME_STEP;
    if (!this.masks || at >= this.masks.numFrames) return null;
    const labels = this.labelsByFrame.get(at) ?? this.masks.labels(at).map((label) => Math.min(1, label));
    this.labelsByFrame.set(at, labels);
    return labels;
  }

  /** Ends the work; nothing is told any more. */
  close() {
    this.onMasks = () => {};
    this.abort.abort();
  }
}
