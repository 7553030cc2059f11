// Painting without a library: noise, soft shapes, sprites, and frames that sprites are laid into. Runs in Node and in
// browsers; the same numbers everywhere.

/** @typedef {[number, number, number]} Colour red, green, blue, 0 to 255 */
/** @typedef {{width: number, height: number, data: Float32Array}} Sprite premultiplied RGBA */
/**
 * How far outside a shape a place lies, in pixels; negative inside. @typedef {(x: number, y: number) => number} Shape
 */

/** A number in 0..1 for each whole place. */
export function hash(x, y, seed = 0) {
  let h = Math.imul(x, 0x27d4eb2d) ^ Math.imul(y, 0x165667b1) ^ Math.imul(seed + 1, 0x9e3779b1);
  h = Math.imul(h ^ (h >>> 15), 0x85ebca6b);
  h = Math.imul(h ^ (h >>> 13), 0xc2b2ae35);
  return ((h ^ (h >>> 16)) >>> 0) / 4294967296;
}

export const clamp = (v, low = 0, high = 1) => Math.min(high, Math.max(low, v));
export const mix = (a, b, k) => a + (b - a) * k;
export const blend = (a, b, k) => [mix(a[0], b[0], k), mix(a[1], b[1], k), mix(a[2], b[2], k)];
export const lit = (colour, by) => [colour[0] * by, colour[1] * by, colour[2] * by];
export const ramp = (from, to, v) => {
  const k = clamp((v - from) / (to - from));
  return k * k * (3 - 2 * k);
};

/** Value noise, 0 to 1, of about one bump a unit. */
export function noise(x, y, seed = 0) {
  const [i, j] = [Math.floor(x), Math.floor(y)];
  const [u, v] = [x - i, y - j];
  const [a, b] = [u * u * (3 - 2 * u), v * v * (3 - 2 * v)];
  const top = mix(hash(i, j, seed), hash(i + 1, j, seed), a);
  return mix(top, mix(hash(i, j + 1, seed), hash(i + 1, j + 1, seed), a), b);
}

/** Noise of several octaves, 0 to 1. */
export function clouds(x, y, seed = 0, octaves = 4) {
  let [sum, total, size] = [0, 0, 1];
  for (let k = 0; k < octaves; k += 1) {
    sum += size * noise(x * 2 ** k, y * 2 ** k, seed + 17 * k);
    total += size;
    size *= 0.55;
  }
  return sum / total;
}

/** @returns {Shape} */
export const ellipse =
  (cx, cy, rx, ry = rx) =>
  (x, y) =>
    (Math.hypot((x - cx) / rx, (y - cy) / ry) - 1) * Math.min(rx, ry);

/** A box with round corners. @returns {Shape} */
export const box =
  (cx, cy, rx, ry, round = 0) =>
  (x, y) => {
    const [dx, dy] = [Math.abs(x - cx) - rx + round, Math.abs(y - cy) - ry + round];
    return Math.hypot(Math.max(dx, 0), Math.max(dy, 0)) + Math.min(Math.max(dx, dy), 0) - round;
  };

/** A thick line from one place to another, tapering if its ends differ. @returns {Shape} */
export const limb = (ax, ay, bx, by, ra, rb = ra) => {
  const [dx, dy] = [bx - ax, by - ay];
  const length = dx * dx + dy * dy || 1;
  return (x, y) => {
    const k = clamp(((x - ax) * dx + (y - ay) * dy) / length);
    return Math.hypot(x - ax - k * dx, y - ay - k * dy) - mix(ra, rb, k);
  };
};

/** What lies within all of these half planes, each through two places with the inside to its right. @returns {Shape} */
export const polygon = (...corners) => {
  const edges = corners.map(([x, y], k) => {
    const [nx, ny] = corners[(k + 1) % corners.length];
    const length = Math.hypot(nx - x, ny - y);
    return [x, y, (ny - y) / length, (x - nx) / length];
  });
  return (x, y) => Math.max(...edges.map(([ex, ey, nx, ny]) => (x - ex) * nx + (y - ey) * ny));
};

/** @returns {Shape} */
export const both =
  (...shapes) =>
  (x, y) =>
    Math.max(...shapes.map((shape) => shape(x, y)));

/** @returns {Shape} */
export const any =
  (...shapes) =>
  (x, y) =>
    Math.min(...shapes.map((shape) => shape(x, y)));

/**
 * A sprite of shapes, each over those before it.
 * @param {number} width
 * @param {number} height
 * @param {[shape: Shape, colour: Colour | ((x: number, y: number) => Colour)][]} parts
 * @param {number} grain how strongly a fine texture lies over it, 0 to 1
 * @returns {Sprite}
 */
export function spriteOf(width, height, parts, grain = 0.25) {
  const data = new Float32Array(4 * width * height);
  for (let y = 0; y < height; y += 1)
    for (let x = 0; x < width; x += 1) {
      const at = 4 * (y * width + x);
      const texture = 1 + grain * (clouds(x / 7, y / 7, 3, 3) - 0.5) + 0.5 * grain * (hash(x, y, 9) - 0.5);
      for (const [shape, colour] of parts) {
        const cover = clamp(0.5 - shape(x, y));
        if (cover <= 0) continue;
        const own = typeof colour === 'function' ? colour(x, y) : colour;
        for (let k = 0; k < 3; k += 1) data[at + k] = mix(data[at + k], own[k] * texture, cover);
        data[at + 3] = mix(data[at + 3], 1, cover);
      }
    }
  return { width, height, data };
}

/** A sprite without holes: a colour for each of its pixels. @returns {Sprite} */
export function pictureOf(width, height, colour) {
  const data = new Float32Array(4 * width * height);
  for (let y = 0; y < height; y += 1)
    for (let x = 0; x < width; x += 1) data.set([...colour(x, y), 1], 4 * (y * width + x));
  return { width, height, data };
}

/**
 * Where a sprite lies: its centre in the frame, how large, turned by how much (radians), mirrored or not.
 * @typedef {{x: number, y: number, size?: number, turn?: number, flip?: boolean, light?: number}} Place
 */

/** A frame that is being painted. */
export class Canvas {
  /**
   * @param {number} width
   * @param {number} height
   */
  constructor(width, height) {
    Object.assign(this, { width, height });
    this.data = new Float32Array(3 * width * height);
  }

  /** A colour for each pixel. @param {(x: number, y: number) => Colour} colour */
  fill(colour) {
    for (let y = 0; y < this.height; y += 1)
      for (let x = 0; x < this.width; x += 1) this.data.set(colour(x, y), 3 * (y * this.width + x));
  }

  /**
   * Lays a sprite over what is there.
   * @param {Sprite} sprite
   * @param {Place} place
   */
  lay(sprite, { x, y, size = 1, turn = 0, flip = false, light = 1 }) {
    const [cos, sin] = [Math.cos(turn) / size, Math.sin(turn) / size];
    const reach = (size * Math.hypot(sprite.width, sprite.height)) / 2 + 1;
    const [left, right] = [Math.max(0, Math.floor(x - reach)), Math.min(this.width - 1, Math.ceil(x + reach))];
    const [top, bottom] = [Math.max(0, Math.floor(y - reach)), Math.min(this.height - 1, Math.ceil(y + reach))];
    for (let row = top; row <= bottom; row += 1)
      for (let column = left; column <= right; column += 1) {
        const [dx, dy] = [column - x, row - y];
        const u = (cos * dx + sin * dy) * (flip ? -1 : 1) + (sprite.width - 1) / 2;
        const v = cos * dy - sin * dx + (sprite.height - 1) / 2;
        this.#over(sprite, u, v, 3 * (row * this.width + column), light);
      }
  }

  #over({ width, height, data }, u, v, at, light) {
    const [i, j] = [Math.floor(u), Math.floor(v)];
    if (i < -1 || j < -1 || i >= width || j >= height) return;
    const sum = [0, 0, 0, 0];
    for (let corner = 0; corner < 4; corner += 1) {
      const [cx, cy] = [i + (corner & 1), j + (corner >> 1)];
      if (cx < 0 || cy < 0 || cx >= width || cy >= height) continue;
      const weight = (corner & 1 ? u - i : 1 - u + i) * (corner >> 1 ? v - j : 1 - v + j);
      for (let k = 0; k < 4; k += 1) sum[k] += weight * data[4 * (cy * width + cx) + k];
    }
    for (let k = 0; k < 3; k += 1) this.data[at + k] = this.data[at + k] * (1 - sum[3]) + light * sum[k];
  }

  /** Darkens softly, as a shadow does. */
  shade(cx, cy, rx, ry, by = 0.45) {
    for (let y = Math.max(0, Math.floor(cy - ry)); y < Math.min(this.height, cy + ry); y += 1)
      for (let x = Math.max(0, Math.floor(cx - rx)); x < Math.min(this.width, cx + rx); x += 1) {
        const dark = 1 - by * (1 - ramp(0.5, 1, Math.hypot((x - cx) / rx, (y - cy) / ry)));
        for (let k = 0; k < 3; k += 1) this.data[3 * (y * this.width + x) + k] *= dark;
      }
  }

  /** As bytes. */
  pixels() {
    const { width, height } = this;
    const data = new Uint8ClampedArray(4 * width * height).fill(255);
    for (let p = 0; p < width * height; p += 1) for (let k = 0; k < 3; k += 1) data[4 * p + k] = this.data[3 * p + k];
    return { width, height, data };
  }
}
