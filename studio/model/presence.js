/**
 * When and where each object is, frame by frame: how large, and its middle. Frames may come one after the other.
 * @module
 */

/** When the frames of a clip are shown. */
export class Times {
  /**
   * @param {number[] | null} seconds of each frame since the beginning of the clip; null where nobody knows
   * @param {number | null} [end] of the last frame, in seconds; null where nobody knows
   */
  constructor(seconds, end = null) {
    this.seconds = seconds;
    this.end = seconds && end;
  }

  /**
   * How long a frame is shown: until the next; the last until the clip's end, or as long as the one before.
   *
   * @param {number} frame
   * @param {number} fps where nobody knows
   * @returns {number} in seconds
   */
  lasts(frame, fps) {
    const { seconds, end } = this;
    if (seconds && end !== null && frame === seconds.length - 1) return end - seconds[frame];
    const from = Math.min(frame, (this.seconds?.length ?? 0) - 2);
    return this.seconds && from >= 0 ? this.seconds[from + 1] - this.seconds[from] : 1 / fps;
  }

  /**
   * @param {number} frame
   * @returns {string} `0.8 s`, `frame 13`
   */
  at(frame) {
    const seconds = this.seconds?.[frame];
    return seconds === undefined ? `frame ${frame + 1}` : `${clock(seconds)}\u00a0s`;
  }

  /**
   * @param {number} first
   * @param {number} last
   * @returns {string} `0.0–1.6 s`, `frames 1–9`
   */
  span(first, last) {
    if (!this.seconds) return first === last ? this.at(first) : `frames ${first + 1}–${last + 1}`;
    return `${clock(this.seconds[first])}–${clock(this.seconds[last])}\u00a0s`;
  }
}

/** @param {number} seconds */
function clock(seconds) {
  return seconds.toFixed(1);
}

/**
 * What is known of one object over the clip.
 *
 * @typedef {object} Facts
 * @property {number} object
 * @property {number} first frame in which it is there; -1 if it never is
 * @property {number} last
 * @property {number} peak frame in which it is largest
 * @property {number} frames in how many it is there
 * @property {number} share of the picture while it is there, in 0..1
 * @property {{x: number, y: number}} from its middle when it is first there, in parts of the picture's width and height
 * @property {{x: number, y: number}} to and at last
 * @property {{x: number, y: number}} moved how far against the scene, in parts of the picture's width and height
 * @property {boolean} followed whether the camera goes with it: it stays about where it is in the picture
 * @property {number} growth its size at last over that at first
 */

/** @typedef {{n: number[], x: number[], y: number[]}} FrameCount Pixels of each object in a frame, and their middle. */

/** A trace of this part of an object's largest size does not count: single pixels come and go. */
const TRACE = 0.02;

/** Frames at either end of an object's time that are taken together, as one frame's mask may be off. */
const ENDS = 3;

/** An object that moves in the picture by less than this part of its way through the scene is followed by the camera. */
const FOLLOWED = 0.4;

export class Presence {
  /** @param {{width: number, height: number}} size of the clip */
  constructor({ width, height }) {
    this.width = width;
    this.height = height;
    /** @type {FrameCount[]} */
    this.frames = [];
  }

  /**
   * @param {Uint8Array} mask of the next frame
   * @param {number} [at] or of this one, which was counted before
   */
  addMask(mask, at = this.frames.length) {
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
   * @param {Float64Array} n
   * @param {Float64Array} x sums
   * @param {Float64Array} y
   * @param {number} at frame
   */
  add(n, x, y, at) {
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

  /**
   * @param {number} object
   * @param {number} frame
   * @returns {number} pixels
   */
  size(object, frame) {
    return this.frames[frame]?.n[object] ?? 0;
  }

  /**
   * @param {number} object
   * @param {number} frame
   * @returns {number} its part of the frame, in 0..1
   */
  part(object, frame) {
    const all = this.frames[frame]?.n.reduce((sum, n) => sum + n, 0) ?? 0;
    return all > 0 ? this.size(object, frame) / all : 0;
  }

  /**
   * @param {number} object
   * @param {number[]} frames
   * @returns {{x: number, y: number}}
   */
  middle(object, frames) {
    const mean = (/** @type {'x' | 'y'} */ axis) =>
      frames.reduce((sum, t) => sum + this.frames[t][axis][object], 0) / frames.length;
    return { x: mean('x'), y: mean('y') };
  }

  /**
   * @param {number} object
   * @param {import('./library.js').SceneMotion | null} [scene] how the scene moves in the picture; not at all where
   *   nobody knows
   * @returns {Facts}
   */
  facts(object, scene = null) {
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
    for (const axis of /** @type {const} */ (['x', 'y'])) {
      const at = (/** @type {number[]} */ list) =>
        list.reduce((total, t) => total + (scene?.[axis][t] ?? 0), 0) / list.length;
      moved[axis] -= (at(end) - at(begin)) / (axis === 'x' ? this.width : this.height);
    }
    const sum = (/** @type {number[]} */ list) => list.reduce((total, t) => total + sizes[t], 0);
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
