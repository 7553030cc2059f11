// Coarse masks of the first frames of a clip, shown during the run. A separate worker computes them from frames that
// the run reads anyway. If it fails, there is no preview.

import { type SessionOptions, type VideoResult, VideoSegmentation, previewMasks } from './library.js';
import type { Source, Trim } from './source.js';

/** Every second frame, eight in all: the package's defaults. */
const FRAME_STEP = 2;
const MAX_FRAMES = 8;

/** Frames from the first to the last of them. */
export const PREVIEW_FRAMES = FRAME_STEP * (MAX_FRAMES - 1) + 1;

/** Smallest number of pixels of a clip with a preview: its run takes about three seconds, as measured. */
const MIN_CLIP_PIXELS = 3.2e6;

/** Returns whether a run takes long enough for a preview. */
export function needsPreview({ width, height }: Source, { frames, side }: Trim): boolean {
  const scale = Math.min(1, side / Math.max(width, height));
  // The user waits for the first window.
  const frameCount = Math.min(frames, VideoSegmentation.defaults.window);
  return frameCount > PREVIEW_FRAMES && width * height * scale ** 2 * frameCount >= MIN_CLIP_PIXELS;
}

export class Preview {
  masks: VideoResult | null;
  labelsByFrame: Map<number, Uint8Array>;
  onMasks: () => void;
  addedCount: number;
  abort: AbortController;
  frames: ReadableStreamDefaultController<ImageData> | undefined;

  /** Starts the worker at once. */
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
      // The package stopped reading.
      this.close();
    }
  }

  /** Returns the last frame with a mask, up to `frame`. */
  maskedFrame(frame: number): number {
    return Math.min(PREVIEW_FRAMES - 1, frame - (frame % FRAME_STEP));
  }

  /**
   * @returns the moving pixels of `maskedFrame(frame)` as one object, at the size of the frames; objects are often
   *   not separable yet
   */
  labels(frame: number): Uint8Array | null {
    const at = this.maskedFrame(frame) / FRAME_STEP;
    if (!this.masks || at >= this.masks.numFrames) return null;
    const labels = this.labelsByFrame.get(at) ?? this.masks.labels(at).map((label) => Math.min(1, label));
    this.labelsByFrame.set(at, labels);
    return labels;
  }

  close() {
    this.onMasks = () => {};
    this.abort.abort();
  }
}
