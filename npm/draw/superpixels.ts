// Superpixels on a canvas: their colours, the borders between them, and the edges that form them (as in Figure 8 of the
// paper).

import { checkFlag, checkNumber, checkOptions, illegal } from '../check/errors.js';
import { EdgeKind } from '../stages/image.js';
import {
  type Context2D,
  createScratch,
  drawOnPixelCentres,
  packColor,
  paintPixels,
  strokeSegments,
  withSavedState,
} from './canvas.js';
import { flowColor } from './labels.js';
import type { MapGrid } from './maps.js';

/** The part of superpixels needed for drawing. */
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

/** Options of `drawSuperpixels`. */
export interface DrawSuperpixelsOptions {
  /** The mean colours of `image`, random colours, or nothing; `mean` if there is an image, else `random`. */
  fill?: 'mean' | 'random' | 'none';
  /** The frame of the superpixels. */
  image?: CanvasImageSource;
  /** Draws lines between superpixels; true if not given. */
  borders?: boolean;
  /** Draws the edges that form them: contours in red, edges that bridge gaps in green; false if not given. */
  edges?: boolean;
  /** Draws the edges of the triangulation that separate nothing; false if not given. */
  deleted?: boolean;
  /** Width of these edges, in pixels of the input; 1.6 if not given. */
  width?: number;
}

const LEGAL = ['fill', 'image', 'borders', 'edges', 'deleted', 'width'];
const FILLS = ['mean', 'random', 'none'];

/** Colours and relative widths of the kinds of edges; later ones are drawn over earlier ones. */
export const EDGE_STYLES = Object.freeze({
  Deleted: Object.freeze({ color: 'rgb(255 255 255 / 0.35)', width: 0.5 }),
  Gabriel: Object.freeze({ color: '#30d158', width: 0.75 }),
  Constraint: Object.freeze({ color: '#ff3b30', width: 1 }),
});

/** Picture pixels along one pixel of the labels: border lines take the outermost of them. */
const UPSCALE = 3;

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
  } = checkOptions(options, LEGAL);
  if (!superpixels?.label || !(superpixels.count > 0))
    throw illegal('data', 'superpixels', superpixels, 'what superpixels() gives');
  if (!FILLS.includes(fill)) throw illegal('param', 'fill', fill, FILLS.map((word) => `'${word}'`).join(', '));
  if (fill === 'mean' && !image) throw illegal('param', 'image', image, "the frame, for fill: 'mean'");
  for (const [name, value] of Object.entries({ borders, edges, deleted })) checkFlag(name, value);
  checkNumber('width', width, 0, 1000);
  if (fill !== 'none' || borders) {
    const colors =
      fill === 'mean' && image
        ? computeMeanColors(context, superpixels, image)
        : fill === 'random'
          ? createRandomColors(superpixels)
          : new Uint32Array(superpixels.count);
    withSavedState(context, () => drawRegions(context, superpixels, colors, borders));
  }
  if (edges || deleted)
    drawOnPixelCentres(context, () =>
      strokeEdges(context, superpixels, { Deleted: deleted, Gabriel: edges, Constraint: edges }, width),
    );
}

function drawRegions(
  context: Context2D,
  { label, width, height, scaleX = 1, scaleY = 1 }: SuperpixelPicture,
  colors: Uint32Array,
  borders: boolean,
) {
  const line = borders ? packColor([20, 22, 26], 200) : null;
  const picture = paintPixels(context, UPSCALE * width, UPSCALE * height, (_, pixels) => {
    for (let y = 0; y < height; y += 1)
      for (let x = 0; x < width; x += 1) paintCell(pixels, { label, width, height }, colors, line, x, y);
  });
  context.drawImage(picture, 0, 0, width * scaleX, height * scaleY);
}

/** Paints one pixel of the labels, with a line towards each neighbour of another label. */
function paintCell(
  pixels: Uint32Array,
  { label, width, height }: { label: ArrayLike<number>; width: number; height: number },
  colors: Uint32Array,
  line: number | null,
  x: number,
  y: number,
) {
  const stride = UPSCALE * width;
  const index = y * width + x;
  const superpixel = Number(label[index]);
  const corner = UPSCALE * (y * stride + x);
  for (let row = 0; row < UPSCALE; row += 1)
    pixels.fill(Number(colors[superpixel]), corner + row * stride, corner + row * stride + UPSCALE);
  if (line === null) return;
  if (x > 0 && label[index - 1] !== superpixel) for (let k = 0; k < UPSCALE; k += 1) pixels[corner + k * stride] = line;
  if (x + 1 < width && label[index + 1] !== superpixel)
    for (let k = 0; k < UPSCALE; k += 1) pixels[corner + k * stride + UPSCALE - 1] = line;
  if (y > 0 && label[index - width] !== superpixel) pixels.fill(line, corner, corner + UPSCALE);
  if (y + 1 < height && label[index + width] !== superpixel)
    pixels.fill(line, corner + (UPSCALE - 1) * stride, corner + (UPSCALE - 1) * stride + UPSCALE);
}

function computeMeanColors(
  context: Context2D,
  { label, width, height, count }: SuperpixelPicture,
  image: CanvasImageSource,
) {
  const target = createScratch(context, width, height, true);
  target.context.drawImage(image, 0, 0, width, height);
  const { data } = target.context.getImageData(0, 0, width, height);
  const sums = new Float64Array(4 * count);
  for (let p = 0; p < label.length; p += 1) {
    const offset = 4 * Number(label[p]);
    for (let c = 0; c < 3; c += 1) sums[offset + c] = Number(sums[offset + c]) + Number(data[4 * p + c]);
    sums[offset + 3] = Number(sums[offset + 3]) + 1;
  }
  return Uint32Array.from({ length: count }, (_, k) =>
    packColor([...sums.subarray(4 * k, 4 * k + 3)].map((sum) => sum / Number(sums[4 * k + 3]))),
  );
}

/** Returns hues in steps of the golden angle, so that neighbours differ. */
function createRandomColors({ count }: SuperpixelPicture): Uint32Array {
  const rgba = new Uint8ClampedArray(4);
  return Uint32Array.from({ length: count }, (_, k) => {
    // The golden angle, in radians.
    const angle = k * 2.399963;
    flowColor(Math.cos(angle), Math.sin(angle), 1.35 + 0.35 * (k % 3), rgba);
    return packColor([...rgba]);
  });
}

function strokeEdges(
  context: Context2D,
  { edges, scaleX = 1, scaleY = 1 }: SuperpixelPicture,
  shownKinds: Record<keyof typeof EDGE_STYLES, boolean>,
  width: number,
) {
  context.lineCap = 'round';
  for (const kind of Object.keys(EDGE_STYLES) as (keyof typeof EDGE_STYLES)[]) {
    if (!shownKinds[kind]) continue;
    const segments: number[] = [];
    for (let e = 0; e < edges.kind.length; e += 1) {
      if (edges.kind[e] !== EdgeKind[kind]) continue;
      const [x0, y0, x1, y1] = [edges.x0, edges.y0, edges.x1, edges.y1].map(
        (list, k) => (Number(list[e]) + 0.5) * (k % 2 ? scaleY : scaleX) - 0.5,
      );
      segments.push(Number(x0), Number(y0), Number(x1), Number(y1));
    }
    context.strokeStyle = EDGE_STYLES[kind].color;
    context.lineWidth = EDGE_STYLES[kind].width * width;
    strokeSegments(context, segments);
  }
}
