// Formats of uncompressed video, and their pixels as RGBA.

import { TraceCutError } from '../check/errors.js';

/**
 * How the bytes of a frame lie: `bytes` a frame, and either planes with chroma, or pixels of `order`, the places of red,
 * green and blue in `step` bytes.
 * @typedef {{width: number, height: number, bytes: number, chroma?: [across: number, down: number] | null, fullRange?:
 *   boolean, order?: [number, number, number], step?: number}} Layout
 */

/**
 * @param {number} width
 * @param {number} height
 * @param {[across: number, down: number] | null} chroma pixels per chroma sample; null without chroma
 * @param {boolean} fullRange
 * @returns {Layout}
 */
function planes(width, height, chroma, fullRange) {
  const samples = chroma ? Math.ceil(width / chroma[0]) * Math.ceil(height / chroma[1]) : 0;
  return { width, height, bytes: width * height + 2 * samples, chroma, fullRange };
}

/**
 * @param {number} step
 * @param {[number, number, number]} order
 * @returns {(width: number, height: number) => Layout}
 */
function packed(step, order) {
  return (width, height) => ({ width, height, bytes: step * width * height, order, step });
}

/** Layouts of raw video by their names in ffmpeg. @type {Map<string, (width: number, height: number) => Layout>} */
export const RAW_FORMATS = new Map([
  ['rgba', packed(4, [0, 1, 2])],
  ['bgra', packed(4, [2, 1, 0])],
  ['rgb24', packed(3, [0, 1, 2])],
  ['bgr24', packed(3, [2, 1, 0])],
  ['gray', packed(1, [0, 0, 0])],
  ['yuv420p', (width, height) => planes(width, height, [2, 2], false)],
  ['yuv422p', (width, height) => planes(width, height, [2, 1], false)],
  ['yuv444p', (width, height) => planes(width, height, [1, 1], false)],
]);

/** @type {Record<string, [number, number] | null>} */
const CHROMA = {
  420: [2, 2],
  '420jpeg': [2, 2],
  '420mpeg2': [2, 2],
  '420paldv': [2, 2],
  422: [2, 1],
  444: [1, 1],
  mono: null,
};

/**
 * The layout that the first line of a Y4M stream tells, and its frame rate, 25 where it tells none. Its size is still to
 * be checked.
 * @param {string} line
 * @returns {Layout & {frameRate: number}}
 */
export function y4mHeader(line) {
  const [name, ...words] = line.trimEnd().split(' ');
  if (name !== 'YUV4MPEG2')
    throw new TraceCutError('no-video', 'the stream is not Y4M (expected it to start with YUV4MPEG2)');
  const tags = new Map(words.filter((word) => !word.startsWith('X')).map((word) => [word[0], word.slice(1)]));
  const chroma = tags.get('C') ?? '420';
  if (!Object.hasOwn(CHROMA, chroma)) {
    const legal = 'C420, C422, C444 or Cmono with 8 bits; with ffmpeg: -pix_fmt yuv420p';
    throw new TraceCutError('codec', `the Y4M stream has pixel format C${chroma} (expected ${legal})`);
  }
  const [width, height] = [Number(tags.get('W')), Number(tags.get('H'))];
  const [frames, seconds] = (tags.get('F') ?? '').split(':').map(Number);
  const frameRate = frames && seconds ? frames / seconds : 25;
  const fullRange = words.includes('XCOLORRANGE=FULL');
  return { ...planes(width, height, CHROMA[chroma] ?? null, fullRange), frameRate };
}

/**
 * @param {Layout} layout
 * @param {Uint8Array} bytes of a frame
 * @returns {import('../worker/frames.js').PixelFrame}
 */
export function framePixels(layout, bytes) {
  const { width, height } = layout;
  const data = new Uint8ClampedArray(4 * width * height).fill(255);
  if (layout.order) fromPacked(layout, bytes, data);
  else fromPlanes(layout, bytes, data);
  return { data, width, height };
}

/**
 * @param {Layout} layout
 * @param {Uint8Array} bytes
 * @param {Uint8ClampedArray} data
 */
function fromPacked({ order = [0, 1, 2], step = 4 }, bytes, data) {
  const [red, green, blue] = order;
  for (let p = 0, q = 0; p < data.length; p += 4, q += step) {
    data[p] = Number(bytes[q + red]);
    data[p + 1] = Number(bytes[q + green]);
    data[p + 2] = Number(bytes[q + blue]);
  }
}

/**
 * What each value of brightness and chroma adds, by ITU-R BT.601 (Kr = 0.299, Kb = 0.114); in 32 bits, as the command
 * line has it.
 * @param {boolean} fullRange
 */
function weights(fullRange) {
  const f = Math.fround;
  const [gain, scale] = fullRange ? [1, 1] : [f(255 / 219), f(255 / 224)];
  const of = (/** @type {(value: number) => number} */ weight) =>
    Float32Array.from({ length: 256 }, (_, value) => weight(value));
  const chroma = (/** @type {number} */ factor) => of((value) => f(factor) * f((value - 128) * f(scale)));
  return {
    luma: of((value) => (fullRange ? value : (value - 16) * f(gain))),
    redOfCr: chroma(1.402),
    greenOfCb: chroma(0.344136),
    greenOfCr: chroma(0.714136),
    blueOfCb: chroma(1.772),
  };
}

/** @type {Map<boolean, ReturnType<typeof weights>>} */
const tables = new Map();

/**
 * Chroma samples are repeated over the pixels that they belong to.
 * @param {Layout} layout
 * @param {Uint8Array} bytes
 * @param {Uint8ClampedArray} data
 */
function fromPlanes({ width, height, chroma, fullRange = false }, bytes, data) {
  const table = tables.get(fullRange) ?? weights(fullRange);
  tables.set(fullRange, table);
  const [across, down] = chroma ?? [1, 1];
  const chromaWidth = Math.ceil(width / across);
  const cb = width * height;
  const cr = cb + chromaWidth * Math.ceil(height / down);
  for (let y = 0, p = 0; y < height; y += 1) {
    const row = Math.floor(y / down) * chromaWidth;
    for (let x = 0; x < width; x += 1, p += 1) {
      const c = row + Math.floor(x / across);
      const [b, r] = chroma ? [Number(bytes[cb + c]), Number(bytes[cr + c])] : [128, 128];
      paint(data, 4 * p, table, Number(bytes[p]), b, r);
    }
  }
}

/**
 * @param {Uint8ClampedArray} data
 * @param {number} q
 * @param {ReturnType<typeof weights>} table
 * @param {number} y
 * @param {number} cb
 * @param {number} cr
 */
function paint(data, q, table, y, cb, cr) {
  const f = Math.fround;
  const luma = Number(table.luma[y]);
  const green = f(f(luma - Number(table.greenOfCb[cb])) - Number(table.greenOfCr[cr]));
  data[q] = Math.floor(f(f(luma + Number(table.redOfCr[cr])) + 0.5));
  data[q + 1] = Math.floor(f(green + 0.5));
  data[q + 2] = Math.floor(f(f(luma + Number(table.blueOfCb[cb])) + 0.5));
}
