// Pixels on their way: pictures with fewer of them, and chunks of PNG files.

/**
 * Each pixel of the answer is the mean of what it covers, so nothing aliases; a canvas would do this differently in
 * each browser.
 * @param frame RGBA
 * @param width at most the frame's
 */
export function reduced(
  { data, width: fromWidth, height: fromHeight }: { data: Uint8Array; width: number; height: number },
  width: number,
  height: number,
) {
  const out = new Uint8ClampedArray(4 * width * height);
  const row = new Float32Array(4 * fromWidth);
  const columns = spans(fromWidth, width);
  const rows = spans(fromHeight, height);
  const area = (fromWidth / width) * (fromHeight / height);
  rows.forEach((span, y) => {
    row.fill(0);
    for (let sy = span.first; sy <= span.last; sy += 1) addRow(row, data, 4 * fromWidth * sy, weight(span, sy));
    columns.forEach((column, x) => {
      const at = 4 * (y * width + x);
      let [red, green, blue, alpha] = [0, 0, 0, 0];
      for (let sx = column.first; sx <= column.last; sx += 1) {
        const share = weight(column, sx) / area;
        red += share * row[4 * sx]!;
        green += share * row[4 * sx + 1]!;
        blue += share * row[4 * sx + 2]!;
        alpha += share * row[4 * sx + 3]!;
      }
      out[at] = red;
      out[at + 1] = green;
      out[at + 2] = blue;
      out[at + 3] = alpha;
    });
  });
  return new Uint8Array(out.buffer);
}

function addRow(sums: Float32Array, data: Uint8Array, from: number, factor: number) {
  for (let i = 0; i < sums.length; i += 1) {
    sums[i] = sums[i]! + factor * data[from + i]!;
  }
}

export type Span = { low: number; high: number; first: number; last: number };

/** What each of `to` pixels covers of `from` pixels. */
function spans(from: number, to: number): Span[] {
  return Array.from({ length: to }, (_, k) => {
    const [low, high] = [(k * from) / to, ((k + 1) * from) / to];
    return { low, high, first: Math.floor(low), last: Math.min(from, Math.ceil(high)) - 1 };
  });
}

/** How much of source pixel `at` the span covers. */
function weight({ low, high }: Span, at: number) {
  return Math.max(0, Math.min(at + 1, high) - Math.max(at, low));
}

/**
 * Pixels row by row. With one channel `data` are values, grey or of a palette; with four they are red, green, blue and
 * opacity, the latter taken from `opacity` where that is given. With `sequence` they are a later frame of an animation.
 */
export type Pixels = {
  data: Uint8Array | Uint8ClampedArray;
  width: number;
  height: number;
  channels: 1 | 4;
  opacity?: Uint8Array;
  sequence?: number;
};

const MAGIC = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];

const COLOR_TYPE = { grey: 0, indexed: 3, rgba: 6 };

/**
 * What comes before the pixels of a file.
 * @param image.rgba four channels; else one
 * @param image.palette red, green and blue of each value, at least of all that occur; grey if not given
 * @param image.alpha of the first values of the palette
 * @param image.numFrames of an animation
 */
export function pngHead({
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
  const parts = [Uint8Array.from(MAGIC), chunk('IHDR', header)];
  if (palette) parts.push(chunk('PLTE', palette));
  if (alpha) parts.push(chunk('tRNS', alpha));
  // An animation plays for ever.
  if (numFrames !== undefined) parts.push(chunk('acTL', words(numFrames, 0)));
  return joined(parts);
}

/** What comes after them. */
export function pngTail() {
  return chunk('IEND', new Uint8Array());
}

/** The longest that a frame of an animation can last, in milliseconds. */
const MOST_MS = 65535;

/**
 * What comes before the pixels of a frame of an animation.
 * @param sequence counts these and the chunks of later frames' pixels
 * @param seconds that it is shown
 */
export function frameHead({ width, height }: { width: number; height: number }, sequence: number, seconds: number) {
  const data = new Uint8Array(26);
  data.set(words(sequence, width, height, 0, 0));
  const view = new DataView(data.buffer);
  view.setUint16(20, Math.min(MOST_MS, Math.max(1, Math.round(1000 * seconds))));
  view.setUint16(22, 1000);
  // The whole picture is another: nothing is kept of the one before, nothing laid over it.
  return chunk('fcTL', data);
}

/**
 * The chunk that holds an image's pixels.
 * @param deflate with zlib's header
 */
export function pixelChunk(pixels: Pixels, deflate: (data: Uint8Array) => Uint8Array) {
  const data = deflate(pixels.channels === 4 ? colorRows(pixels) : rowsOf(pixels));
  const { sequence } = pixels;
  return sequence === undefined ? chunk('IDAT', data) : chunk('fdAT', joined([words(sequence), data]));
}

/**
 * Number of the filter that takes from each byte the one above: of labels nothing is left but edges, which is quick to
 * deflate.
 */
const UP = 2;

/** That which takes the mean of the bytes to the left and above: of pictures little is left. */
const MEAN = 3;

function rowsOf({ data, width, height }: Pixels) {
  const rows = new Uint8Array(height * (width + 1));
  for (let y = 0; y < height; y += 1) {
    const to = y * (width + 1);
    const from = y * width;
    rows[to] = UP;
    for (let x = 0; x < width; x += 1)
      rows[to + 1 + x] = Number(data[from + x]) - (y > 0 ? Number(data[from - width + x]) : 0);
  }
  return rows;
}

/** What is clear has no colour: nobody sees it, and it takes no room. */
function colorRows({ data, width, height, opacity }: Pixels) {
  const size = 4 * width;
  const rows = new Uint8Array(height * (size + 1));
  let [above, row] = [new Uint8Array(size), new Uint8Array(size)];
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const p = y * width + x;
      const alpha = Number(opacity ? opacity[p] : data[4 * p + 3]);
      for (let c = 0; c < 3; c += 1) row[4 * x + c] = alpha > 0 ? Number(data[4 * p + c]) : 0;
      row[4 * x + 3] = alpha;
    }
    const to = y * (size + 1);
    rows[to] = MEAN;
    for (let k = 0; k < size; k += 1) {
      const left = k < 4 ? 0 : Number(row[k - 4]);
      rows[to + 1 + k] = Number(row[k]) - ((left + Number(above[k])) >> 1);
    }
    [above, row] = [row, above];
  }
  return rows;
}

/** Numbers of four bytes, the highest first. */
function words(...numbers: number[]) {
  const bytes = new Uint8Array(4 * numbers.length);
  const view = new DataView(bytes.buffer);
  numbers.forEach((number, k) => view.setUint32(4 * k, number));
  return bytes;
}

function chunk(type: string, data: Uint8Array) {
  const bytes = new Uint8Array(data.length + 12);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, data.length);
  for (let k = 0; k < 4; k += 1) bytes[4 + k] = type.charCodeAt(k);
  bytes.set(data, 8);
  view.setUint32(data.length + 8, crc32(bytes.subarray(4, data.length + 8)));
  return bytes;
}

export function joined(parts: Uint8Array[]) {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

/** The checksum of PNG, by half bytes. */
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
