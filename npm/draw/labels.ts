// Masks on a canvas: every pixel of an object in its colour, with an outline.

import { checkFlag, checkNumber, checkedOptions } from '../check/errors.js';
import { MAX_LABEL, type MaskSource, type ObjectChoice, checkMasks, chosenLabels, labelsOf } from '../check/masks.js';
import { type Context2D, asideFrom, onPixelCentres, outlines, pack, painted, strokePieces } from './canvas.js';
import { type LabelColors, colorsOf, rgbOf } from './palette.js';

export interface DrawLabelsOptions {
  /** Of the fill, 0 to 1; 0.5 if not given. */
  opacity?: number;
  /** True if not given. */
  outline?: boolean;
  /** In pixels of the input; 1.5 if not given. A dark rim of nearly the same width goes beyond it. */
  outlineWidth?: number;
  /** `objectColor` if not given. */
  colors?: LabelColors;
  /** All but the background if not given. */
  objects?: ObjectChoice;
}

const LEGAL = ['opacity', 'outline', 'outlineWidth', 'colors', 'objects'];

/** A dark rim of this many outline widths keeps the outline legible on bright footage. */
const RIM = { color: 'rgb(0 0 0 / 0.3)', width: 1.9 };

const MAX_WIDTH = 1000;

/**
 * Draws the masks of frame `t`. The context's unit is one pixel of the input, its origin the frame's upper left corner
 * (see `fitFrame`).
 */
export function drawLabels(context: Context2D, masks: MaskSource, t: number, options: DrawLabelsOptions = {}) {
  checkMasks(masks);
  const { opacity = 0.5, outline = true, outlineWidth = 1.5, colors, objects } = checkedOptions(options, LEGAL);
  checkNumber('opacity', opacity, 0, 1);
  checkNumber('outlineWidth', outlineWidth, 0, MAX_WIDTH);
  checkFlag('outline', outline);
  const labels = labelsOf(masks, t);
  const { width, height } = masks;
  const chosen = chosenLabels(objects);
  const color = colorsOf(colors);
  if (opacity > 0) fillLabels(context, { labels, width, height }, chosen, color, opacity);
  if (!outline || outlineWidth === 0) return;
  onPixelCentres(context, () => {
    context.lineCap = 'round';
    for (const [label, pieces] of [...outlines(labels, width, height, chosen)].sort(([a], [b]) => a - b)) {
      for (const [style, stroke] of [
        [RIM.color, RIM.width * outlineWidth],
        [color(label), outlineWidth],
      ] as const) {
        context.strokeStyle = style;
        context.lineWidth = stroke;
        strokePieces(context, pieces);
      }
    }
  });
}

function fillLabels(
  context: Context2D,
  { labels, width, height }: { labels: Uint8Array; width: number; height: number },
  chosen: Uint8Array,
  color: (label: number) => string,
  opacity: number,
) {
  asideFrom(context, () => {
    const picture = labelPicture(context, { labels, width, height }, chosen, color);
    context.globalAlpha *= opacity;
    context.drawImage(picture, 0, 0, width, height);
  });
}

/** A picture of the labels, clear where none is that was chosen. */
function labelPicture(
  context: Context2D,
  { labels, width, height }: { labels: Uint8Array; width: number; height: number },
  chosen: Uint8Array,
  color: (label: number) => string,
) {
  const seen = new Uint8Array(MAX_LABEL + 1);
  for (let p = 0; p < labels.length; p += 1) seen[Number(labels[p])] = 1;
  const fill = Uint32Array.from(seen, (there, label) => (there && chosen[label] ? pack(rgbOf(color(label))) : 0));
  return painted(context, width, height, (_, pixels) => {
    for (let p = 0; p < pixels.length; p += 1) pixels[p] = Number(fill[Number(labels[p])]);
  });
}
