// When and where each object is, frame by frame: how large, and its middle. Frames may come one after the other.

import type { SceneMotion } from './library.js';

/** When the frames of a clip are shown. */
export class Times {
  end: number | null;

  /**
   * @param seconds of each frame since the beginning of the clip; null where nobody knows
   * @param end of the last frame, in seconds; null where nobody knows
   */
  constructor(
    public seconds: number[] | null,
    end: number | null = null,
  ) {
    this.end = seconds && end;
  }

  /**
   * How long a frame is shown: until the next; the last until the clip's end, or as long as the one before.
   * @param fps where nobody knows
   * @returns in seconds
   */
  lasts(frame: number, fps: number): number {
    const { seconds, end } = this;
    if (seconds && end !== null && frame === seconds.length - 1) return end - seconds[frame];
    const from = Math.min(frame, (this.seconds?.length ?? 0) - 2);
    return this.seconds && from >= 0 ? this.seconds[from + 1] - this.seconds[from] : 1 / fps;
  }

  /** Returns `0.8 s`, `frame 13`. */
  at(frame: number): string {
    const seconds = this.seconds?.[frame];
    return seconds === undefined ? `frame ${frame + 1}` : `${clock(seconds)}\u00a0s`;
  }

  /** Returns `0.0–1.6 s`, `frames 1–9`. */
  span(first: number, last: number): string {
    if (!this.seconds) return first === last ? this.at(first) : `frames ${first + 1}–${last + 1}`;
    return `${clock(this.seconds[first])}–${clock(this.seconds[last])}\u00a0s`;
  }
}

function clock(seconds: number) {
  return seconds.toFixed(1);
}

/** What is known of one object over the clip. */
export interface Facts {
  object: number;
  /** Frame in which it is there; -1 if it never is. */
  first: number;
  last: number;
  /** Frame in which it is largest. */
  peak: number;
  /** In how many it is there. */
  frames: number;
  /** Of the picture while it is there, in 0..1. */
  share: number;
  /** Its middle when it is first there, in parts of the picture's width and height. */
  from: { x: number; y: number };
  /** And at last. */
  to: { x: number; y: number };
  /** How far against the scene, in parts of the picture's width and height. */
  moved: { x: number; y: number };
  /** Whether the camera goes with it: it stays about where it is in the picture. */
  followed: boolean;
  /** Its size at last over that at first. */
  growth: number;
}

/** Pixels of each object in a frame, and their middle. */
type FrameCount = { n: number[]; x: number[]; y: number[] };

/** A trace of this part of an object's largest size does not count: single pixels come and go. */
const TRACE = 0.02;

/** Frames at either end of an object's time that are taken together, as one frame's mask may be off. */
const ENDS = 3;

/** An object that moves in the picture by less than this part of its way through the scene is followed by the camera. */
const FOLLOWED = 0.4;

export class Presence {
  width: number;
  height: number;
  frames: FrameCount[] = [];

  constructor({ width, height }: { width: number; height: number }) {
    this.width = width;
    this.height = height;
  }

  /** @param at or of this one, which was counted before */
  addMask(mask: Uint8Array, at: number = this.frames.length) {
    const { width, height } = this;
    const n = new Float64Array(256);
    const x = new Float64Array(256);
    const y = new Float64Array(256);
    for (let row = 0; row < height; row++) {
      const begin = row * width;
      // By runs of equal labels: there are few of them.
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
   * @param x sums
   * @param at frame
   */
  add(n: Float64Array, x: Float64Array, y: Float64Array, at: number) {
    let most = n.length;
    while (most > 0 && n[most - 1] === 0) most -= 1;
    const counts = [...n.subarray(0, most)];
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

  /** Returns the share of the frame that it covers, 0 to 1. */
  part(object: number, frame: number): number {
    const all = this.frames[frame]?.n.reduce((sum, n) => sum + n, 0) ?? 0;
    return all > 0 ? this.size(object, frame) / all : 0;
  }

  middle(object: number, frames: number[]): { x: number; y: number } {
    const mean = (axis: 'x' | 'y') => frames.reduce((sum, t) => sum + this.frames[t][axis][object], 0) / frames.length;
    return { x: mean('x'), y: mean('y') };
  }

  /** @param scene how the scene moves in the picture; not at all where nobody knows */
  facts(object: number, scene: SceneMotion | null = null): Facts {
    const sizes = this.frames.map((_, t) => this.size(object, t));
    const largest = sizes.reduce((a, b) => Math.max(a, b), 0);
    const there = sizes.flatMap((n, t) => (n > 0 && n >= TRACE * largest ? [t] : []));
    const nowhere = { x: 0.5, y: 0.5 };
    if (there.length === 0)
      return {
        ...{ object, first: -1, last: -1, peak: 0, frames: 0, share: 0 },
        ...{ from: nowhere, to: nowhere, moved: { x: 0, y: 0 }, followed: false, growth: 1 },
      };
    const begin = there.slice(0, ENDS);
    const end = there.slice(-ENDS);
    const [from, to] = [this.middle(object, begin), this.middle(object, end)];
    const moved = { x: to.x - from.x, y: to.y - from.y };
    const inPicture = Math.hypot(moved.x, moved.y);
    for (const axis of ['x', 'y'] as const) {
      const at = (list: number[]) => list.reduce((total, t) => total + (scene?.[axis][t] ?? 0), 0) / list.length;
      moved[axis] -= (at(end) - at(begin)) / (axis === 'x' ? this.width : this.height);
    }
    const sum = (list: number[]) => list.reduce((total, t) => total + sizes[t], 0);
    return {
      object,
      first: there[0],
      last: there[there.length - 1],
      peak: sizes.indexOf(largest),
      frames: there.length,
      share: there.reduce((total, t) => total + this.part(object, t), 0) / there.length,
      from,
      to,
      moved,
      followed: inPicture < FOLLOWED * Math.hypot(moved.x, moved.y),
      growth: sum(end) / end.length / (sum(begin) / begin.length),
    };
  }
}
