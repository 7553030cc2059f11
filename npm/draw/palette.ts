// Colours and marker shapes of objects, colours of saliency and of motion.

import { illegal, wholeNumber } from '../check/errors.js';

/** A point's shape. */
export type Shape = 'disc' | 'square' | 'diamond';

/** A colour for each label: a list that starts with label 0's, or a function; each `#rrggbb`. */
export type LabelColors = readonly string[] | ((label: number) => string);

const MAX_LABEL = 255;

/** The background, muted. */
const BACKGROUND = '#a3a7ad';

/**
 * Okabe and Ito's hues, which stay apart for people with the common colour-vision deficiencies; the ones furthest apart
 * on film first.
 */
const FIRST_HUES = ['#e69f00', '#56b4e9', '#cc79a7', '#f0e442', '#009e73', '#d55e00', '#0072b2'];

/** Red of discontinuities and of the foreground; no object has it. */
export const CUT_RED = '#ff2b3d';

/** The green of screens: what cut-out objects lie on in a file that cannot be transparent. */
export const SCREEN_GREEN = '#00b140';

/** Levels of a channel that the colours of further objects are chosen from. */
const LEVELS = [0, 36, 73, 109, 146, 182, 219, 255];

const SHAPES: Shape[] = ['disc', 'square', 'diamond'];

/** The colours of all labels, made when first asked for. */
const colors = made(allColors);

/**
 * The colour of a label: grey for the background, then seven hues that stay apart for people with the common
 * colour-vision deficiencies, then ever closer ones; no two labels have the same.
 * @param label 0 to 255
 * @returns `#rrggbb`
 */
export function objectColor(label: number): string {
  return String(colors()[wholeNumber('param', 'label', label, 0, MAX_LABEL)]);
}

/**
 * The shape of a label's points: it changes every seven labels, so that colour is never the only difference.
 * @param label 0 to 255
 */
export function objectShape(label: number): Shape {
  wholeNumber('param', 'label', label, 0, MAX_LABEL);
  return SHAPES[Math.floor(Math.max(0, label - 1) / FIRST_HUES.length) % SHAPES.length] ?? 'disc';
}

/**
 * From the eighth object on: of all colours on a grid, again and again the one furthest from those that are taken.
 * Whole numbers only, so it comes out the same everywhere.
 */
function allColors(): string[] {
  const taken = [BACKGROUND, ...FIRST_HUES];
  const grid: number[][] = [];
  for (const r of LEVELS) for (const g of LEVELS) for (const b of LEVELS) grid.push([r, g, b]);
  const room = grid.map(() => Infinity);
  const claim = (color: string) => {
    const own = rgbOf(color);
    grid.forEach((candidate, k) => (room[k] = Math.min(Number(room[k]), difference(candidate, own))));
  };
  ['#000000', '#ffffff', CUT_RED, ...taken].forEach(claim);
  while (taken.length <= MAX_LABEL) {
    const best = room.reduce((most, value, k) => (value > Number(room[most]) ? k : most), 0);
    const color = `#${(grid[best] ?? []).map((level) => level.toString(16).padStart(2, '0')).join('')}`;
    taken.push(color);
    claim(color);
  }
  return taken;
}

/** How far two colours are apart to the eye, about: red counts more among bright reds, blue among dark ones. */
function difference([r0 = 0, g0 = 0, b0 = 0]: number[], [r1 = 0, g1 = 0, b1 = 0]: number[]) {
  const red = r0 + r1;
  return (1024 + red) * (r0 - r1) ** 2 + 2048 * (g0 - g1) ** 2 + (1534 - red) * (b0 - b1) ** 2;
}

/**
 * @param color `#rrggbb`
 * @returns 0..255
 */
export function rgbOf(color: string): [number, number, number] {
  if (typeof color !== 'string' || !/^#[0-9a-f]{6}$/i.test(color)) throw illegal('param', 'colour', color, '#rrggbb');
  const n = Number.parseInt(color.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}

/** The colour of each label; labels without one of their own take the palette's. */
export function colorsOf(given: LabelColors | undefined): (label: number) => string {
  if (given === undefined) return objectColor;
  if (typeof given === 'function') return (label) => given(label) ?? objectColor(label);
  if (!Array.isArray(given))
    throw illegal('param', 'colors', given, 'a list of colours #rrggbb, or a function of a label');
  return (label) => given[label] ?? objectColor(label);
}

/** Colours of saliency from 0 to 1 in equal steps: ever brighter, so that they also tell without their hues. */
const HEAT = ['#0b0b24', '#35175f', '#7a2178', '#bd3a5e', '#ec6f3c', '#fbb340', '#fdf3a0'];

/** Hues of the flow wheel at equal angles, from motion to the right (0 rad) on through motion down. */
const WHEEL = ['#e8463c', '#f0a11f', '#e6e03a', '#4fc24a', '#2cb7b0', '#3b83e0', '#6a52d8', '#cf4bb4'];

const heat = made(() => HEAT.map(rgbOf));
const wheel = made(() => WHEEL.map(rgbOf));

/**
 * The colour of a saliency: dark for none to bright for most.
 * @param value 0 to 1
 * @param out takes red, green, blue and alpha (255) at `at`
 * @param at 0 if not given
 */
export function heatColor(value: number, out: Uint8ClampedArray, at = 0) {
  const stops = heat();
  const place = Math.min(1, Math.max(0, value)) * (stops.length - 1);
  const below = Math.min(stops.length - 2, Math.floor(place));
  blend(stops[below], stops[below + 1], place - below, 1, out, at);
}

/**
 * The colour of a motion: the hue is its direction, white is no motion, full colour is `scale` pixels or more.
 * @param u motion to the right, in pixels
 * @param v motion down, in pixels
 * @param scale motion with full colour, in pixels, above 0
 * @param out takes red, green, blue and alpha (255) at `at`
 * @param at 0 if not given
 */
export function flowColor(u: number, v: number, scale: number, out: Uint8ClampedArray, at = 0) {
  const stops = wheel();
  const turn = ((Math.atan2(v, u) / (2 * Math.PI) + 1) % 1) * stops.length;
  const below = Math.floor(turn) % stops.length;
  blend(
    stops[below],
    stops[(below + 1) % stops.length],
    turn - Math.floor(turn),
    Math.min(1, Math.hypot(u, v) / scale),
    out,
    at,
  );
}

/**
 * Between two colours, and then as far from white as `strength` says.
 * @param share of `b`
 */
function blend(
  [r0 = 0, g0 = 0, b0 = 0]: number[] | undefined = [],
  [r1 = 0, g1 = 0, b1 = 0]: number[] | undefined = [],
  share: number,
  strength: number,
  out: Uint8ClampedArray,
  at: number,
) {
  out[at] = 255 + (r0 + (r1 - r0) * share - 255) * strength;
  out[at + 1] = 255 + (g0 + (g1 - g0) * share - 255) * strength;
  out[at + 2] = 255 + (b0 + (b1 - b0) * share - 255) * strength;
  out[at + 3] = 255;
}

/** Makes something when it is first asked for. */
function made<T>(make: () => T): () => T {
  let known: T | undefined;
  return () => (known ??= make());
}
