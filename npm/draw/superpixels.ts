// Superpixels on a canvas: their colours, the lines between them, and the edges that they are made of (as in Figure 8
// of the paper).

import { checkFlag, checkNumber, checkedOptions, illegal } from '../check/errors.js';
import { EdgeKind } from '../stages/image.js';
import { type Context2D, asideFrom, onPixelCentres, pack, painted, scratch, strokePieces } from './canvas.js';
import { flowColor } from './palette.js';
import type { MapGrid } from './maps.js';

/** The part of superpixels that drawing needs. */
export type SuperpixelPicture = MapGrid & {
  count: number;
  label: ArrayLike<number>;
  edges: {
    x0: ArrayLike<number>;
    y0: ArrayLike<number>;
    x1: ArrayLike<number>;
    y1: ArrayLike<number>;
    kind: ArrayLike<number>;
  };
};

export interface DrawSuperpixelsOptions {
  /** The mean colours of `image`, colours at random, or nothing; `mean` if there is an image, else `random`. */
  fill?: 'mean' | 'random' | 'none';
  /** The frame that the superpixels are of. */
  image?: CanvasImageSource;
  /** Lines between superpixels; true if not given. */
  borders?: boolean;
  /** The edges that they are made of, contours in red, edges that bridge gaps in green; false if not given. */
  edges?: boolean;
  /** Also the edges of the triangulation that separate nothing; false if not given. */
  deleted?: boolean;
  /** Of these edges, in pixels of the input; 1.6 if not given. */
  width?: number;
}

const LEGAL = ['fill', 'image', 'borders', 'edges', 'deleted', 'width'];
const FILLS = ['mean', 'random', 'none'];

/** Colours of the kinds of edges, and their widths against each other; later ones lie over earlier ones. */
export const EDGE_STYLES = Object.freeze({
  Deleted: Object.freeze({ color: 'rgb(255 255 255 / 0.35)', width: 0.5 }),
  Gabriel: Object.freeze({ color: '#30d158', width: 0.75 }),
  Constraint: Object.freeze({ color: '#ff3b30', width: 1 }),
});

/** Pixels of the picture along one pixel of the labels: lines take the outermost of them. */
const FINE = 3;

/**
 * Draws superpixels. The context's unit is one pixel of the input, its origin the frame's upper left corner (see
 * `fitFrame`).
 */
export function drawSuperpixels(
  context: Context2D,
  superpixels: SuperpixelPicture,
  options: DrawSuperpixelsOptions = {},
) {
  const {
    image,
    fill = image ? 'mean' : 'random',
    borders = true,
    edges = false,
    deleted = false,
    width = 1.6,
  } = checkedOptions(options, LEGAL);
  if (!superpixels?.label || !(superpixels.count > 0))
    throw illegal('data', 'superpixels', superpixels, 'what superpixels() gives');
  if (!FILLS.includes(fill)) throw illegal('param', 'fill', fill, FILLS.map((word) => `'${word}'`).join(', '));
  if (fill === 'mean' && !image) throw illegal('param', 'image', image, "the frame, for fill: 'mean'");
  for (const [name, value] of Object.entries({ borders, edges, deleted })) checkFlag(name, value);
  checkNumber('width', width, 0, 1000);
  if (fill !== 'none' || borders) {
    const colors =
      fill === 'mean' && image
        ? meanColors(context, superpixels, image)
        : fill === 'random'
          ? randomColors(superpixels)
          : new Uint32Array(superpixels.count);
    asideFrom(context, () => drawRegions(context, superpixels, colors, borders));
  }
  if (edges || deleted)
    onPixelCentres(context, () =>
      strokeEdges(context, superpixels, { Deleted: deleted, Gabriel: edges, Constraint: edges }, width),
    );
}

function drawRegions(
  context: Context2D,
  { label, width, height, scaleX = 1, scaleY = 1 }: SuperpixelPicture,
  colors: Uint32Array,
  borders: boolean,
) {
  const line = borders ? pack([20, 22, 26], 200) : null;
  const picture = painted(context, FINE * width, FINE * height, (_, pixels) => {
    for (let y = 0; y < height; y += 1)
      for (let x = 0; x < width; x += 1) paintCell(pixels, { label, width, height }, colors, line, x, y);
  });
  context.drawImage(picture, 0, 0, width * scaleX, height * scaleY);
}

/** One pixel of the labels, with a line where the next one is of another. */
function paintCell(
  pixels: Uint32Array,
  { label, width, height }: { label: ArrayLike<number>; width: number; height: number },
  colors: Uint32Array,
  line: number | null,
  x: number,
  y: number,
) {
  const stride = FINE * width;
  const at = y * width + x;
  const own = Number(label[at]);
  const corner = FINE * (y * stride + x);
  for (let row = 0; row < FINE; row += 1)
    pixels.fill(Number(colors[own]), corner + row * stride, corner + row * stride + FINE);
  if (line === null) return;
  if (x > 0 && label[at - 1] !== own) for (let k = 0; k < FINE; k += 1) pixels[corner + k * stride] = line;
  if (x + 1 < width && label[at + 1] !== own)
    for (let k = 0; k < FINE; k += 1) pixels[corner + k * stride + FINE - 1] = line;
  if (y > 0 && label[at - width] !== own) pixels.fill(line, corner, corner + FINE);
  if (y + 1 < height && label[at + width] !== own)
    pixels.fill(line, corner + (FINE - 1) * stride, corner + (FINE - 1) * stride + FINE);
}

function meanColors(context: Context2D, { label, width, height, count }: SuperpixelPicture, image: CanvasImageSource) {
  const aside = scratch(context, width, height, true);
  aside.context.drawImage(image, 0, 0, width, height);
  const { data } = aside.context.getImageData(0, 0, width, height);
  const sums = new Float64Array(4 * count);
  for (let p = 0; p < label.length; p += 1) {
    const at = 4 * Number(label[p]);
    for (let c = 0; c < 3; c += 1) sums[at + c] = Number(sums[at + c]) + Number(data[4 * p + c]);
    sums[at + 3] = Number(sums[at + 3]) + 1;
  }
  return Uint32Array.from({ length: count }, (_, k) =>
    pack([...sums.subarray(4 * k, 4 * k + 3)].map((sum) => sum / Number(sums[4 * k + 3]))),
  );
}

/** Returns hues in steps of the golden angle, so that neighbours differ. */
function randomColors({ count }: SuperpixelPicture): Uint32Array {
  const rgba = new Uint8ClampedArray(4);
  return Uint32Array.from({ length: count }, (_, k) => {
    const turn = k * 2.399963;
    flowColor(Math.cos(turn), Math.sin(turn), 1.35 + 0.35 * (k % 3), rgba);
    return pack([...rgba]);
  });
}

function strokeEdges(
  context: Context2D,
  { edges, scaleX = 1, scaleY = 1 }: SuperpixelPicture,
  wanted: Record<keyof typeof EDGE_STYLES, boolean>,
  width: number,
) {
  context.lineCap = 'round';
  for (const kind of Object.keys(EDGE_STYLES) as (keyof typeof EDGE_STYLES)[]) {
    if (!wanted[kind]) continue;
    const pieces: number[] = [];
    for (let e = 0; e < edges.kind.length; e += 1) {
      if (edges.kind[e] !== EdgeKind[kind]) continue;
      const [x0, y0, x1, y1] = [edges.x0, edges.y0, edges.x1, edges.y1].map(
        (list, k) => (Number(list[e]) + 0.5) * (k % 2 ? scaleY : scaleX) - 0.5,
      );
      pieces.push(Number(x0), Number(y0), Number(x1), Number(y1));
    }
    context.strokeStyle = EDGE_STYLES[kind].color;
    context.lineWidth = EDGE_STYLES[kind].width * width;
    strokePieces(context, pieces);
  }
}
