// The masks of a result, frame by frame, and where its objects are.

import { sceneMotion } from './library.js';
import { Presence } from './presence.js';

/**
 * A result, as the page looks at it. `trajectories` holds points of trajectory `i` at `offset[i]..offset[i + 1]`, the
 * first of them in frame `startFrame[i]`, in pixels of the masks, and the object of each as its `label`.
 */
export interface Result {
  width: number;
  height: number;
  numFrames: number;
  trajectories: {
    count: number;
    startFrame: Uint32Array;
    offset: Uint32Array;
    x: Float32Array;
    y: Float32Array;
    label: ArrayLike<number>;
  };
  /** Of a clip that is one window. */
  clusters?: { count: number; label: ArrayLike<number> };
  objects: readonly { label: number }[];
  labels: (t: number) => Uint8Array;
  toTracksDat: () => string | Promise<string>;
}

/** Masks that are kept; those of a long clip lie elsewhere in a small form. */
const MASKS = 64;

/** Answers are kept, so playing costs nothing after the first round. */
export class Points {
  masks = new Map<number, Uint8Array>();
  /** One more than the highest label. */
  count: number;
  /** How the scene moves in the picture. */
  scene: ReturnType<typeof sceneMotion>;
  presence: Presence;

  /** @param presence where that is known already */
  constructor(
    public result: Result,
    presence: Presence | null = null,
  ) {
    this.count = Math.max(0, ...result.objects.map(({ label }) => label)) + 1;
    this.scene = sceneMotion(result);
    this.presence = presence ?? new Presence(result);
    for (let t = this.presence.frames.length; t < result.numFrames; t++) this.presence.addMask(result.labels(t));
  }

  /** Returns the object of each pixel; null of frames that are not settled yet. */
  mask(frame: number): Uint8Array | null {
    if (frame >= this.result.numFrames) return null;
    const mask = this.masks.get(frame) ?? this.result.labels(frame);
    this.masks.delete(frame);
    this.masks.set(frame, mask);
    if (this.masks.size > MASKS) this.masks.delete(this.masks.keys().next().value!);
    return mask;
  }

  /**
   * @param px pixels of the masks
   * @returns the object there; -1 outside of the frame
   */
  objectAt(frame: number, px: number, py: number): number {
    const { width, height } = this.result;
    const [x, y] = [Math.round(px), Math.round(py)];
    const inside = x >= 0 && y >= 0 && x < width && y < height;
    return inside ? (this.mask(frame)?.[y * width + x] ?? -1) : -1;
  }
}
