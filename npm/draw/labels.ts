// Masks on a canvas: each object filled in its colour, with an outline.

import { checkFlag, checkNumber, checkOptions } from '../check/errors.js';
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
import { type LabelColors, parseColor, toColorFunction } from './palette.js';

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
