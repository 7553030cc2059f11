// Size and centre of each object in each frame. Frames can be added one by one.
// A result caches masks, so that playback is fast.

import { type FrameRange, type LabelledTrajectories, sceneMotion, type SceneMotion } from './library.js';

/** Timestamps of the frames of a clip. */
export class Times {
  end: number | null;

  /**
   * @param seconds of each frame since the start of the clip; null if unknown
   * @param end of the last frame, in seconds; null if unknown
   */
  constructor(
    public seconds: number[] | null,
    end: number | null = null,
  ) {
    this.end = seconds && end;
  }

  /**
   * Returns the duration of a frame in seconds. The last frame lasts until the end of the clip, or as long as the one
   * before.
   * @param fps used if times are unknown
   */
  durationOf(frame: number, fps: number): number {
    const { seconds, end } = this;
    if (seconds && end !== null && frame === seconds.length - 1) return end - seconds[frame];
    const from = Math.min(frame, (this.seconds?.length ?? 0) - 2);
    return this.seconds && from >= 0 ? this.seconds[from + 1] - this.seconds[from] : 1 / fps;
  }

  /** Returns `0.8 s`, `frame 13`. */
  format(frame: number): string {
    const seconds = this.seconds?.[frame];
    return seconds === undefined ? `frame ${frame + 1}` : `${clock(seconds)}\u00a0s`;
  }

  /** Returns `0.0–1.6 s`, `frames 1–9`. */
  formatSpan(first: number, last: number): string {
    if (!this.seconds) return first === last ? this.format(first) : `frames ${first + 1}–${last + 1}`;
    return `${clock(this.seconds[first])}–${clock(this.seconds[last])}\u00a0s`;
  }
}

function clock(seconds: number) {
  return seconds.toFixed(1);
}

/** Size, position and motion of one object over the clip. */
export interface ObjectFacts {
  object: number;
  /** First frame with the object; -1 if there is none. */
  first: number;
  last: number;
  /** Frame in which it is largest. */
  peak: number;
  /** Number of frames with the object. */
  frames: number;
  /** Mean share of the picture in those frames, in 0..1. */
  share: number;
  /** First centre, as shares of the picture's width and height. */
  from: { x: number; y: number };
  /** Last centre. */
  to: { x: number; y: number };
  /** Motion relative to the scene, as shares of the picture's width and height. */
  motion: { x: number; y: number };
  /** True if the camera follows it: it moves little in the picture. */
  isFollowed: boolean;
  /** Last size divided by first size. */
  growth: number;
}

/** Pixels and centre of each object in a frame. */
type FrameCount = { n: number[]; x: number[]; y: number[] };

/** Smaller sizes, as a share of the object's largest, are ignored as noise; chosen by eye. */
const MIN_SIZE_SHARE = 0.02;

/** Frames averaged at the start and the end, as single masks may be wrong; chosen by eye. */
const END_FRAMES = 3;

/**
 * An object is followed by the camera if its motion in the picture is below this share of its motion in the scene;
 * chosen by eye.
 */
const MAX_FOLLOWED_MOTION = 0.4;

export class Presence {
  width: number;
  height: number;
  frames: FrameCount[] = [];

  constructor({ width, height }: { width: number; height: number }) {
    this.width = width;
    this.height = height;
  }

  /**
   * Counts a mask.
   * @param at its frame; counted again if known
   */
  addMask(mask: Uint8Array, at: number = this.frames.length) {
    const { width, height } = this;
    const n = new Float64Array(256);
    const x = new Float64Array(256);
    const y = new Float64Array(256);
    for (let row = 0; row < height; row++) {
      const begin = row * width;
      // Runs of equal labels are few.
      for (let from = 0, to = 1; from < width; from = to++) {
        const object = mask[begin + from];
        while (to < width && mask[begin + to] === object) to++;
        n[object] += to - from;
        x[object] += ((to - from) * (from + to - 1)) / 2;
        y[object] += (to - from) * row;
      }
    }
    this.add(n, x, y, at);
  }

  /**
   * @param n pixels by object
   * @param x sums by object
   * @param y sums by object
   */
  add(n: Float64Array, x: Float64Array, y: Float64Array, at: number) {
    let end = n.length;
    while (end > 0 && n[end - 1] === 0) end -= 1;
    const counts = [...n.subarray(0, end)];
    const { width, height } = this;
    this.frames[at] = {
      n: counts,
      x: counts.map((count, k) => (count > 0 ? (x[k] / count + 0.5) / width : 0)),
      y: counts.map((count, k) => (count > 0 ? (y[k] / count + 0.5) / height : 0)),
    };
  }

  size(object: number, frame: number): number {
    return this.frames[frame]?.n[object] ?? 0;
  }

  /** Returns the share of the frame that an object covers, 0 to 1. */
  shareOf(object: number, frame: number): number {
    const total = this.frames[frame]?.n.reduce((sum, n) => sum + n, 0) ?? 0;
    return total > 0 ? this.size(object, frame) / total : 0;
  }

  centreOf(object: number, frames: number[]): { x: number; y: number } {
    const mean = (axis: 'x' | 'y') => frames.reduce((sum, t) => sum + this.frames[t][axis][object], 0) / frames.length;
    return { x: mean('x'), y: mean('y') };
  }

  /** @param scene motion of the scene in the picture; none if unknown */
  facts(object: number, scene: SceneMotion | null = null): ObjectFacts {
    const sizes = this.frames.map((_, t) => this.size(object, t));
    const largest = sizes.reduce((a, b) => Math.max(a, b), 0);
    const frames = sizes.flatMap((n, t) => (n > 0 && n >= MIN_SIZE_SHARE * largest ? [t] : []));
    const centre = { x: 0.5, y: 0.5 };
    if (frames.length === 0)
      return {
        ...{ object, first: -1, last: -1, peak: 0, frames: 0, share: 0 },
        ...{ from: centre, to: centre, motion: { x: 0, y: 0 }, isFollowed: false, growth: 1 },
      };
    const begin = frames.slice(0, END_FRAMES);
    const end = frames.slice(-END_FRAMES);
    const [from, to] = [this.centreOf(object, begin), this.centreOf(object, end)];
    const motion = { x: to.x - from.x, y: to.y - from.y };
    const inPicture = Math.hypot(motion.x, motion.y);
    for (const axis of ['x', 'y'] as const) {
      const at = (list: number[]) => list.reduce((total, t) => total + (scene?.[axis][t] ?? 0), 0) / list.length;
      motion[axis] -= (at(end) - at(begin)) / (axis === 'x' ? this.width : this.height);
    }
    const sum = (list: number[]) => list.reduce((total, t) => total + sizes[t], 0);
    return {
      object,
      first: frames[0],
      last: frames[frames.length - 1],
      peak: sizes.indexOf(largest),
      frames: frames.length,
      share: frames.reduce((total, t) => total + this.shareOf(object, t), 0) / frames.length,
      from,
      to,
      motion,
      isFollowed: inPicture < MAX_FOLLOWED_MOTION * Math.hypot(motion.x, motion.y),
      growth: sum(end) / end.length / (sum(begin) / begin.length),
    };
  }
}

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
  /** Confidence in the masks of each frame, 0 to 1, NaN if unknown; null if unknown for all. */
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
