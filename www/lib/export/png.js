// Writes PNG files of one byte a pixel. The same pixels give the same bytes everywhere.

/**
 * @typedef {(data: Uint8Array, options?: {level?: 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9}) => Uint8Array<ArrayBuffer>}
 *   Deflate
 */

const MAGIC = [0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a];

const COLOR_TYPE = { grey: 0, indexed: 3 };

/**
 * @param {object} image
 * @param {Uint8Array} image.pixels row by row
 * @param {number} image.width
 * @param {number} image.height
 * @param {Uint8Array} [image.palette] red, green and blue of each value, at least of all that occur; grey if not given
 * @param {Uint8Array} [image.alpha] of the first values of the palette
 * @param {Deflate} deflate with zlib's header
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function encodePng({ pixels, width, height, palette, alpha }, deflate) {
  const header = new Uint8Array(13);
  const view = new DataView(header.buffer);
  view.setUint32(0, width);
  view.setUint32(4, height);
  header.set([8, palette ? COLOR_TYPE.indexed : COLOR_TYPE.grey, 0, 0, 0], 8);
  const parts = [Uint8Array.from(MAGIC), chunk('IHDR', header)];
  if (palette) parts.push(chunk('PLTE', palette));
  if (alpha) parts.push(chunk('tRNS', alpha));
  parts.push(chunk('IDAT', deflate(rowsOf(pixels, width, height), { level: 6 })), chunk('IEND', new Uint8Array()));
  return joined(parts);
}

/**
 * Number of the filter that takes from each byte the one above: of labels nothing is left but edges, which is quick to
 * deflate.
 */
const UP = 2;

/**
 * @param {Uint8Array} pixels
 * @param {number} width
 * @param {number} height
 */
function rowsOf(pixels, width, height) {
  const rows = new Uint8Array(height * (width + 1));
  for (let y = 0; y < height; y += 1) {
    const to = y * (width + 1);
    const from = y * width;
    rows[to] = UP;
    for (let x = 0; x < width; x += 1)
      rows[to + 1 + x] = Number(pixels[from + x]) - (y > 0 ? Number(pixels[from - width + x]) : 0);
  }
  return rows;
}

/**
 * @param {string} type
 * @param {Uint8Array} data
 */
function chunk(type, data) {
  const bytes = new Uint8Array(data.length + 12);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, data.length);
  for (let k = 0; k < 4; k += 1) bytes[4 + k] = type.charCodeAt(k);
  bytes.set(data, 8);
  view.setUint32(data.length + 8, crc32(bytes.subarray(4, data.length + 8)));
  return bytes;
}

/** @param {Uint8Array[]} parts */
function joined(parts) {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

/** The checksum of PNG, by half bytes. @param {Uint8Array} bytes */
function crc32(bytes) {
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
