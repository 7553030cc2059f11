// Reduces pictures, and encodes chunks of PNG files.

/**
 * Reduces a frame: each pixel of the result is the mean of the area that it covers, so nothing aliases. A canvas would do
 * this differently in each browser.
 * @param frame RGBA
 * @param width at most the frame's
 */
export function reducePixels(
  { data, width: fromWidth, height: fromHeight }: { data: Uint8Array; width: number; height: number },
  width: number,
  height: number,
) {
  const out = new Uint8ClampedArray(4 * width * height);
  const row = new Float32Array(4 * fromWidth);
  const columns = createSpans(fromWidth, width);
  const area = (fromWidth / width) * (fromHeight / height);
  const shares = Float64Array.from(
    columns.flatMap((column) => computeOverlaps(column)),
    (overlap) => overlap / area,
  );
  createSpans(fromHeight, height).forEach((span, y) => {
    sumRows(row, data, span);
    let index = 4 * y * width;
    let next = 0;
    columns.forEach(({ first, last }) => {
      let red = 0;
      let green = 0;
      let blue = 0;
      let alpha = 0;
      for (let from = 4 * first; from <= 4 * last; from += 4) {
        const share = shares[next++]!;
        red += share * row[from]!;
        green += share * row[from + 1]!;
        blue += share * row[from + 2]!;
        alpha += share * row[from + 3]!;
      }
      out[index++] = red;
      out[index++] = green;
      out[index++] = blue;
      out[index++] = alpha;
    });
  });
  return new Uint8Array(out.buffer);
}

/** Most bytes whose sum fits into 16 bits. */
const MAX_PACKED_ROWS = 257;

/** Computes the sums of the rows that a span covers, each by its share. */
function sumRows(sums: Float32Array, data: Uint8Array, span: Span) {
  const { low, high, first, last } = span;
  const isWhole = low === first && high === last + 1 && high - low <= MAX_PACKED_ROWS;
  if (isWhole && data.byteOffset % 4 === 0) return sumWholeRows(sums, data, span);
  sums.fill(0);
  computeOverlaps(span).forEach((factor, k) => addRow(sums, data, (first + k) * sums.length, factor));
}

function addRow(sums: Float32Array, data: Uint8Array, from: number, factor: number) {
  for (let i = 0; i < sums.length; i += 1) {
    sums[i] = sums[i]! + factor * data[from + i]!;
  }
}

/** Computes the sums of whole rows, two channels in one number: three times as fast. */
function sumWholeRows(sums: Float32Array, data: Uint8Array, { first, last }: Span) {
  const width = sums.length / 4;
  const pixels = new Uint32Array(data.buffer, data.byteOffset, data.length / 4);
  for (let x = 0; x < width; x += 1) {
    let redAndBlue = 0;
    let greenAndAlpha = 0;
    for (let from = first * width + x; from <= last * width + x; from += width) {
      const pixel = pixels[from]!;
      redAndBlue += pixel & 0xff00ff;
      greenAndAlpha += (pixel >>> 8) & 0xff00ff;
    }
    sums[4 * x] = redAndBlue & 0xffff;
    sums[4 * x + 1] = greenAndAlpha & 0xffff;
    sums[4 * x + 2] = redAndBlue >>> 16;
    sums[4 * x + 3] = greenAndAlpha >>> 16;
  }
}

type Span = { low: number; high: number; first: number; last: number };

/** Returns the range of `from` pixels that each of `to` pixels covers. */
function createSpans(from: number, to: number): Span[] {
  return Array.from({ length: to }, (_, k) => {
    const [low, high] = [(k * from) / to, ((k + 1) * from) / to];
    return { low, high, first: Math.floor(low), last: Math.min(from, Math.ceil(high)) - 1 };
  });
}

/** Computes the share of each source pixel that the span covers. */
function computeOverlaps({ low, high, first, last }: Span) {
  return Array.from({ length: last - first + 1 }, (_, k) =>
    Math.max(0, Math.min(first + k + 1, high) - Math.max(first + k, low)),
  );
}

/**
 * Pixels row by row. With one channel `data` are grey values or indices of a palette; with four they are red, green, blue
 * and opacity, the latter from `opacity` if given. With `sequence` they are a later frame of an animation.
 */
export type PngPixels = {
  data: Uint8Array | Uint8ClampedArray;
  width: number;
  height: number;
  channels: 1 | 4;
  opacity?: Uint8Array;
  sequence?: number;
};

const SIGNATURE = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];

const COLOR_TYPE = { grey: 0, indexed: 3, rgba: 6 };

/**
 * Encodes the chunks before the pixels of a file.
 * @param image.rgba true for four channels, else one
 * @param image.palette red, green and blue of each value, at least of all used ones; grey if not given
 * @param image.alpha opacity of the first values of the palette
 * @param image.numFrames number of frames of an animation
 */
export function encodeHead({
  width,
  height,
  rgba = false,
  palette,
  alpha,
  numFrames,
}: {
  width: number;
  height: number;
  rgba?: boolean;
  palette?: Uint8Array;
  alpha?: Uint8Array;
  numFrames?: number;
}) {
  const header = new Uint8Array(13);
  const view = new DataView(header.buffer);
  view.setUint32(0, width);
  view.setUint32(4, height);
  header.set([8, COLOR_TYPE[rgba ? 'rgba' : palette ? 'indexed' : 'grey'], 0, 0, 0], 8);
  const parts = [Uint8Array.from(SIGNATURE), encodeChunk('IHDR', header)];
  if (palette) parts.push(encodeChunk('PLTE', palette));
  if (alpha) parts.push(encodeChunk('tRNS', alpha));
  // An animation loops forever.
  if (numFrames !== undefined) parts.push(encodeChunk('acTL', encodeNumbers(numFrames, 0)));
  return concatenate(parts);
}

/** Encodes the chunk after the pixels of a file. */
export function encodeTail() {
  return encodeChunk('IEND', new Uint8Array());
}

/** Longest duration of a frame of an animation that fits into 16 bits. */
const MAX_MS = 65535;

/**
 * Encodes the chunk before the pixels of a frame of an animation.
 * @param sequence number of this chunk, counting headers and the pixel chunks of later frames
 * @param seconds duration
 */
export function encodeFrameHead(
  { width, height }: { width: number; height: number },
  sequence: number,
  seconds: number,
) {
  const data = new Uint8Array(26);
  data.set(encodeNumbers(sequence, width, height, 0, 0));
  const view = new DataView(data.buffer);
  view.setUint16(20, Math.min(MAX_MS, Math.max(1, Math.round(1000 * seconds))));
  view.setUint16(22, 1000);
  // Each frame replaces the whole picture: nothing of the one before stays, nothing is blended.
  return encodeChunk('fcTL', data);
}

/**
 * Encodes the chunk of an image's pixels.
 * @param deflate with zlib's header
 */
export function encodePixels(pixels: PngPixels, deflate: (data: Uint8Array) => Uint8Array) {
  const data = deflate(pixels.channels === 4 ? filterColors(pixels) : filterLabels(pixels));
  const { sequence } = pixels;
  return sequence === undefined
    ? encodeChunk('IDAT', data)
    : encodeChunk('fdAT', concatenate([encodeNumbers(sequence), data]));
}

/** Number of the filter that subtracts the byte above: only edges of labels remain, which deflate quickly. */
const UP_FILTER = 2;

/** Number of the filter that subtracts the mean of the bytes to the left and above: little of pictures remains. */
const AVERAGE_FILTER = 3;

function filterLabels({ data, width, height }: PngPixels) {
  const rows = new Uint8Array(height * (width + 1));
  for (let y = 0; y < height; y += 1) {
    const to = y * (width + 1);
    const from = y * width;
    rows[to] = UP_FILTER;
    for (let x = 0; x < width; x += 1)
      rows[to + 1 + x] = Number(data[from + x]) - (y > 0 ? Number(data[from - width + x]) : 0);
  }
  return rows;
}

/** Filters rows of RGBA. Transparent pixels get no colour: it is invisible, and compresses better. */
function filterColors({ data, width, height, opacity }: PngPixels) {
  const size = 4 * width;
  const rows = new Uint8Array(height * (size + 1));
  const isClear = (p: number) => (opacity ? opacity[p] : data[4 * p + 3]) === 0;
  let [above, row] = [new Uint8Array(size), new Uint8Array(size)];
  let hasAbove = false;
  for (let y = 0; y < height; y += 1) {
    const start = y * width;
    let [left, right] = [0, width];
    while (left < right && isClear(start + left)) left += 1;
    while (left < right && isClear(start + right - 1)) right -= 1;
    rows[y * (size + 1)] = AVERAGE_FILTER;
    // Most rows of cut-out objects are clear in large parts.
    if (left === right && !hasAbove) continue;
    row.fill(0);
    for (let x = left; x < right; x += 1) {
      const p = start + x;
      const alpha = opacity ? opacity[p]! : data[4 * p + 3]!;
      if (alpha === 0) continue;
      for (let c = 0; c < 3; c += 1) row[4 * x + c] = data[4 * p + c]!;
      row[4 * x + 3] = alpha;
    }
    const to = y * (size + 1) + 1;
    const [first, last] = hasAbove ? [0, size] : [4 * left, Math.min(size, 4 * right + 4)];
    for (let k = first; k < last; k += 1) rows[to + k] = row[k]! - (((k < 4 ? 0 : row[k - 4]!) + above[k]!) >> 1);
    hasAbove = left < right;
    [above, row] = [row, above];
  }
  return rows;
}

/** Encodes numbers as four bytes, the highest first. */
function encodeNumbers(...numbers: number[]) {
  const bytes = new Uint8Array(4 * numbers.length);
  const view = new DataView(bytes.buffer);
  numbers.forEach((number, k) => view.setUint32(4 * k, number));
  return bytes;
}

function encodeChunk(type: string, data: Uint8Array) {
  const bytes = new Uint8Array(data.length + 12);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, data.length);
  for (let k = 0; k < 4; k += 1) bytes[4 + k] = type.charCodeAt(k);
  bytes.set(data, 8);
  view.setUint32(data.length + 8, crc32(bytes.subarray(4, data.length + 8)));
  return bytes;
}

export function concatenate(parts: Uint8Array[]) {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let offset = 0;
  for (const part of parts) {
    bytes.set(part, offset);
    offset += part.length;
  }
  return bytes;
}

/** Computes the checksum of PNG, by half bytes. */
function crc32(bytes: Uint8Array) {
  const table = Uint32Array.from({ length: 16 }, (_, k) => {
    let value = k;
    for (let bit = 0; bit < 4; bit += 1) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
    return value;
  });
  let crc = -1;
  for (const byte of bytes) {
    crc ^= byte;
    crc = (crc >>> 4) ^ Number(table[crc & 15]);
    crc = (crc >>> 4) ^ Number(table[crc & 15]);
  }
  return ~crc >>> 0;
}
