// Colours of objects and values, and drawing of masks.

import { checkFlag, checkNumber, checkOptions, checkWholeNumber, illegal } from '../check/errors.js';
import { MAX_LABEL, type MaskSource, type ObjectChoice, checkMasks, readLabels, selectLabels } from '../check/masks.js';
import {
  type Context2D,
  drawOnPixelCentres,
  packColor,
  paintPixels,
  strokeSegments,
  traceOutlines,
  withSavedState,
} from './canvas.js';

/** Shape of a point's marker. */
export type Shape = 'disc' | 'square' | 'diamond';

/** Colours by label: a list that starts with label 0, or a function; each `#rrggbb`. */
export type LabelColors = readonly string[] | ((label: number) => string);

/** Colour of the background, muted. */
const BACKGROUND = '#a3a7ad';

/** Okabe and Ito's hues for people with common colour-vision deficiencies, the most distinct on film first. */
const FIRST_HUES = ['#e69f00', '#56b4e9', '#cc79a7', '#f0e442', '#009e73', '#d55e00', '#0072b2'];

/** Red of discontinuities and of the foreground; no object has it. */
export const CUT_RED = '#ff2b3d';

/** Green-screen green: the backdrop of cut-out objects in a file that cannot be transparent. */
export const SCREEN_GREEN = '#00b140';

/** Channel levels from which the colours of further objects are chosen. */
const LEVELS = [0, 36, 73, 109, 146, 182, 219, 255];

const SHAPES: Shape[] = ['disc', 'square', 'diamond'];

/** Colours of all labels, computed on first use. */
const getColors = lazy(computePalette);

/**
 * Returns the colour of a label: grey for the background, then seven hues that people with common colour-vision
 * deficiencies can tell apart, then ever closer ones; no two labels have the same.
 * @param label 0 to 255
 * @returns `#rrggbb`
 */
export function objectColor(label: number): string {
  return String(getColors()[checkWholeNumber('param', 'label', label, 0, MAX_LABEL)]);
}

/**
 * Returns the marker shape of a label: it changes every seven labels, so that colour is never the only difference.
 * @param label 0 to 255
 */
export function objectShape(label: number): Shape {
  checkWholeNumber('param', 'label', label, 0, MAX_LABEL);
  return SHAPES[Math.floor(Math.max(0, label - 1) / FIRST_HUES.length) % SHAPES.length] ?? 'disc';
}

/**
 * Computes the palette. From the eighth object on it takes, of all colours on a grid, the one furthest from those
 * already taken. Whole numbers only, so the result is the same everywhere.
 */
function computePalette(): string[] {
  const palette = [BACKGROUND, ...FIRST_HUES];
  const grid: number[][] = [];
  for (const r of LEVELS) for (const g of LEVELS) for (const b of LEVELS) grid.push([r, g, b]);
  const distances = grid.map(() => Infinity);
  const addColor = (color: string) => {
    const rgb = parseColor(color);
    grid.forEach(
      (candidate, k) => (distances[k] = Math.min(Number(distances[k]), computeColorDistance(candidate, rgb))),
    );
  };
  ['#000000', '#ffffff', CUT_RED, ...palette].forEach(addColor);
  while (palette.length <= MAX_LABEL) {
    const farthest = distances.reduce((most, value, k) => (value > Number(distances[most]) ? k : most), 0);
    const color = `#${(grid[farthest] ?? []).map((level) => level.toString(16).padStart(2, '0')).join('')}`;
    palette.push(color);
    addColor(color);
  }
  return palette;
}

/** Computes an approximate perceived distance of two colours: red counts more among bright reds, blue among dark ones. */
function computeColorDistance([r0 = 0, g0 = 0, b0 = 0]: number[], [r1 = 0, g1 = 0, b1 = 0]: number[]) {
  const red = r0 + r1;
  return (1024 + red) * (r0 - r1) ** 2 + 2048 * (g0 - g1) ** 2 + (1534 - red) * (b0 - b1) ** 2;
}

/**
 * Parses `#rrggbb`.
 * @returns 0 to 255 each
 */
export function parseColor(color: string): [number, number, number] {
  if (typeof color !== 'string' || !/^#[0-9a-f]{6}$/i.test(color)) throw illegal('param', 'colour', color, '#rrggbb');
  const n = Number.parseInt(color.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}

/** Returns a function from label to colour; labels without a given colour take the palette's. */
export function toColorFunction(colors: LabelColors | undefined): (label: number) => string {
  if (colors === undefined) return objectColor;
  if (typeof colors === 'function') return (label) => colors(label) ?? objectColor(label);
  if (!Array.isArray(colors))
    throw illegal('param', 'colors', colors, 'a list of colours #rrggbb, or a function of a label');
  return (label) => colors[label] ?? objectColor(label);
}

/** Colours of saliency from 0 to 1 in equal steps: ever brighter, so that they differ without their hues too. */
const HEAT = ['#0b0b24', '#35175f', '#7a2178', '#bd3a5e', '#ec6f3c', '#fbb340', '#fdf3a0'];

/** Hues of the flow wheel at equal angles, from motion to the right (0 rad) on through motion down. */
const WHEEL = ['#e8463c', '#f0a11f', '#e6e03a', '#4fc24a', '#2cb7b0', '#3b83e0', '#6a52d8', '#cf4bb4'];

const getHeatStops = lazy(() => HEAT.map(parseColor));
const getWheelStops = lazy(() => WHEEL.map(parseColor));

/**
 * Writes the colour of a saliency: dark for none to bright for most.
 * @param value 0 to 1
 * @param out takes red, green, blue and alpha (255) at `offset`
 * @param offset 0 if not given
 */
export function heatColor(value: number, out: Uint8ClampedArray, offset = 0) {
  const stops = getHeatStops();
  const position = Math.min(1, Math.max(0, value)) * (stops.length - 1);
  const below = Math.min(stops.length - 2, Math.floor(position));
  blend(stops[below], stops[below + 1], position - below, 1, out, offset);
}

/**
 * Writes the colour of a motion: the hue is its direction, white is no motion, full colour is `scale` pixels or more.
 * @param u motion to the right, in pixels
 * @param v motion down, in pixels
 * @param scale motion with full colour, in pixels, above 0
 * @param out takes red, green, blue and alpha (255) at `offset`
 * @param offset 0 if not given
 */
export function flowColor(u: number, v: number, scale: number, out: Uint8ClampedArray, offset = 0) {
  const stops = getWheelStops();
  const angle = ((Math.atan2(v, u) / (2 * Math.PI) + 1) % 1) * stops.length;
  const below = Math.floor(angle) % stops.length;
  blend(
    stops[below],
    stops[(below + 1) % stops.length],
    angle - Math.floor(angle),
    Math.min(1, Math.hypot(u, v) / scale),
    out,
    offset,
  );
}

/**
 * Mixes two colours, then moves the result away from white by `strength`.
 * @param share of the second colour
 */
function blend(
  [r0 = 0, g0 = 0, b0 = 0]: number[] | undefined = [],
  [r1 = 0, g1 = 0, b1 = 0]: number[] | undefined = [],
  share: number,
  strength: number,
  out: Uint8ClampedArray,
  offset: number,
) {
  out[offset] = 255 + (r0 + (r1 - r0) * share - 255) * strength;
  out[offset + 1] = 255 + (g0 + (g1 - g0) * share - 255) * strength;
  out[offset + 2] = 255 + (b0 + (b1 - b0) * share - 255) * strength;
  out[offset + 3] = 255;
}

/** Returns a function that computes a value once, on first use. */
function lazy<T>(compute: () => T): () => T {
  let value: T | undefined;
  return () => (value ??= compute());
}

/** Options of `drawLabels`. */
export interface DrawLabelsOptions {
  /** Opacity of the fill, 0 to 1; 0.5 if not given. */
  opacity?: number;
  /** Draws outlines; true if not given. */
  outline?: boolean;
  /** Width in pixels of the input; 1.5 if not given. A dark border of nearly the same width goes beyond it. */
  outlineWidth?: number;
  /** Colours by label; `objectColor` if not given. */
  colors?: LabelColors;
  /** Objects to draw; all but the background if not given. */
  objects?: ObjectChoice;
}

const LEGAL = ['opacity', 'outline', 'outlineWidth', 'colors', 'objects'];

/** Dark border that keeps the outline legible on bright footage; its width in outline widths, chosen by eye. */
const OUTLINE_BORDER = { color: 'rgb(0 0 0 / 0.3)', width: 1.9 };

/** Widest outline. */
const MAX_OUTLINE_PX = 1000;

/**
 * Draws the masks of frame `t`. The context's unit is one pixel of the input, its origin the frame's upper left corner
 * (see `fitFrame`).
 */
export function drawLabels(context: Context2D, masks: MaskSource, t: number, options: DrawLabelsOptions = {}) {
  checkMasks(masks);
  const { opacity = 0.5, outline = true, outlineWidth = 1.5, colors, objects } = checkOptions(options, LEGAL);
  checkNumber('opacity', opacity, 0, 1);
  checkNumber('outlineWidth', outlineWidth, 0, MAX_OUTLINE_PX);
  checkFlag('outline', outline);
  const labels = readLabels(masks, t);
  const { width, height } = masks;
  const selected = selectLabels(objects);
  const color = toColorFunction(colors);
  if (opacity > 0) fillLabels(context, { labels, width, height }, selected, color, opacity);
  if (!outline || outlineWidth === 0) return;
  drawOnPixelCentres(context, () => {
    context.lineCap = 'round';
    for (const [label, pieces] of [...traceOutlines(labels, width, height, selected)].sort(([a], [b]) => a - b)) {
      for (const [style, stroke] of [
        [OUTLINE_BORDER.color, OUTLINE_BORDER.width * outlineWidth],
        [color(label), outlineWidth],
      ] as const) {
        context.strokeStyle = style;
        context.lineWidth = stroke;
        strokeSegments(context, pieces);
      }
    }
  });
}

function fillLabels(
  context: Context2D,
  { labels, width, height }: { labels: Uint8Array; width: number; height: number },
  selected: Uint8Array,
  color: (label: number) => string,
  opacity: number,
) {
  withSavedState(context, () => {
    const picture = paintLabels(context, { labels, width, height }, selected, color);
    context.globalAlpha *= opacity;
    context.drawImage(picture, 0, 0, width, height);
  });
}

/** Paints the selected labels; all other pixels stay clear. */
function paintLabels(
  context: Context2D,
  { labels, width, height }: { labels: Uint8Array; width: number; height: number },
  selected: Uint8Array,
  color: (label: number) => string,
) {
  const present = new Uint8Array(MAX_LABEL + 1);
  for (let p = 0; p < labels.length; p += 1) present[Number(labels[p])] = 1;
  const fill = Uint32Array.from(present, (isPresent, label) =>
    isPresent && selected[label] ? packColor(parseColor(color(label))) : 0,
  );
  return paintPixels(context, width, height, (_, pixels) => {
    for (let p = 0; p < pixels.length; p += 1) pixels[p] = Number(fill[Number(labels[p])]);
  });
}
