/**
 * Colours and marker shapes of objects.
 *
 * Object 0 is the background and is muted. The others take the seven hues of Okabe and Ito,
 * which stay apart for people with the common colour-vision deficiencies; from the eighth object on the marker's
 * shape changes, so that colour is never the only difference.
 * @module
 */

/** @typedef {{r: number, g: number, b: number}} Rgb Components in 0..255. */
/** @typedef {'disc' | 'square' | 'diamond'} Shape */

/** Okabe and Ito's hues, the ones furthest apart on film first. */
const OBJECT_HUES = ['#e69f00', '#56b4e9', '#cc79a7', '#f0e442', '#009e73', '#d55e00', '#0072b2'];

const BACKGROUND = '#a3a7ad';

/** @type {Shape[]} */
const SHAPES = ['disc', 'square', 'diamond'];

/** Red of discontinuities and of the foreground; no object has it. */
export const CUT_RED = '#ff2b3d';

/** Points that are there but not meant. */
export const FAINT = 'rgb(255 255 255 / 0.45)';

/**
 * @param {number} object index, 0 is the background
 * @returns {string} CSS colour `#rrggbb`
 */
export function objectColor(object) {
  return object === 0 ? BACKGROUND : OBJECT_HUES[(object - 1) % OBJECT_HUES.length];
}

/**
 * @param {number} object
 * @returns {Shape} the marker; changes each time the hues start over
 */
export function objectShape(object) {
  if (object === 0) return 'disc';
  return SHAPES[Math.floor((object - 1) / OBJECT_HUES.length) % SHAPES.length];
}

/**
 * @param {number} object
 * @returns {string}
 */
export function objectName(object) {
  return object === 0 ? 'Background' : `Object ${object}`;
}

/**
 * @param {string} hex `#rrggbb`
 * @returns {Rgb}
 */
export function rgbOf(hex) {
  const n = Number.parseInt(hex.slice(1), 16);
  return { r: n >> 16, g: (n >> 8) & 255, b: n & 255 };
}

/** Colours of saliency from 0 to 1 in equal steps: ever brighter, so that they also tell without their hues. */
const HEAT = ['#0b0b24', '#35175f', '#7a2178', '#bd3a5e', '#ec6f3c', '#fbb340', '#fdf3a0'].map(rgbOf);

/**
 * @param {number} value 0 to 1
 * @param {Uint8ClampedArray} out takes red, green, blue, alpha at `at`
 * @param {number} at
 */
export function heatColor(value, out, at) {
  const place = Math.min(1, Math.max(0, value)) * (HEAT.length - 1);
  const below = Math.min(HEAT.length - 2, Math.floor(place));
  const share = place - below;
  const [a, b] = [HEAT[below], HEAT[below + 1]];
  out[at] = a.r + (b.r - a.r) * share;
  out[at + 1] = a.g + (b.g - a.g) * share;
  out[at + 2] = a.b + (b.b - a.b) * share;
  out[at + 3] = 255;
}

/** Hues of the flow wheel at equal angles, from motion to the right (0 rad) on through motion down. */
const WHEEL = ['#e8463c', '#f0a11f', '#e6e03a', '#4fc24a', '#2cb7b0', '#3b83e0', '#6a52d8', '#cf4bb4'].map(rgbOf);

/**
 * Colour of a motion: the hue is the direction, white is no motion, full colour is `scale` pixels or more.
 *
 * @param {number} u motion to the right, in pixels
 * @param {number} v motion down, in pixels
 * @param {number} scale motion with full colour, in pixels, above 0
 * @param {Uint8ClampedArray} out takes red, green, blue, alpha at `at`
 * @param {number} at
 */
export function flowColor(u, v, scale, out, at) {
  const strength = Math.min(1, Math.hypot(u, v) / scale);
  const turn = ((Math.atan2(v, u) / (2 * Math.PI) + 1) % 1) * WHEEL.length;
  const below = Math.floor(turn) % WHEEL.length;
  const share = turn - Math.floor(turn);
  const a = WHEEL[below];
  const b = WHEEL[(below + 1) % WHEEL.length];
  out[at] = 255 + (a.r + (b.r - a.r) * share - 255) * strength;
  out[at + 1] = 255 + (a.g + (b.g - a.g) * share - 255) * strength;
  out[at + 2] = 255 + (a.b + (b.b - a.b) * share - 255) * strength;
  out[at + 3] = 255;
}
