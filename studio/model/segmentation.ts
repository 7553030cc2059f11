// A result with cached masks and the positions of its objects.

import { type FrameRange, type LabelledTrajectories, sceneMotion } from './library.js';
import { Presence } from './presence.js';

/**
 * A result in the form that the page uses. `trajectories` holds the points of trajectory `i` at `offset[i]..offset[i
 * + 1]`, starting in frame `startFrame[i]`, in pixels of the masks; `label` is its object.
 */
export interface Result extends LabelledTrajectories {
  width: number;
  height: number;
  trajectories: LabelledTrajectories['trajectories'] & { label: ArrayLike<number> };
  /** Present if the clip fits into one window. */
  clusters?: { count: number; label: ArrayLike<number> };
  objects: readonly { label: number }[];
  labels: (t: number) => Uint8Array;
  toTracksDat: () => string | Promise<string>;
  /** Frames whose masks should be looked at. */
  doubts: readonly FrameRange[];
  /** How sure the masks of each frame are, 0 to 1, NaN if not known; null if no frame is. */
  agreement?: Float32Array | null;
}

/** Number of cached masks; masks of long clips are stored compressed elsewhere. */
const MAX_CACHED_MASKS = 64;

/** Caches masks, so that repeated playback is fast. */
export class Segmentation {
  masks = new Map<number, Uint8Array>();
  /** One more than the highest label. */
  count: number;
  /** Motion of the scene in the picture. */
  scene: ReturnType<typeof sceneMotion>;
  presence: Presence;

  /** @param presence if counted already */
  constructor(
    public result: Result,
    presence: Presence | null = null,
  ) {
    this.count = Math.max(0, ...result.objects.map(({ label }) => label)) + 1;
    this.scene = sceneMotion(result);
    this.presence = presence ?? new Presence(result);
    for (let t = this.presence.frames.length; t < result.numFrames; t++) this.presence.addMask(result.labels(t));
  }

  /** Returns the object of each pixel; null if the frame is not finished. */
  mask(frame: number): Uint8Array | null {
    if (frame >= this.result.numFrames) return null;
    const mask = this.masks.get(frame) ?? this.result.labels(frame);
    this.masks.delete(frame);
    this.masks.set(frame, mask);
    if (this.masks.size > MAX_CACHED_MASKS) this.masks.delete(this.masks.keys().next().value!);
    return mask;
  }

  /**
   * @param px pixels of the masks
   * @returns the object there; -1 outside the frame
   */
  objectAt(frame: number, px: number, py: number): number {
    const { width, height } = this.result;
    const [x, y] = [Math.round(px), Math.round(py)];
    const inside = x >= 0 && y >= 0 && x < width && y < height;
    return inside ? (this.mask(frame)?.[y * width + x] ?? -1) : -1;
  }
}
