// Writes PNG files for the tests of the package and of the page.

import { deflateSync, inflateSync } from 'node:zlib';

/** Colour types of PNG by the number of bytes a pixel. */
const COLOR_TYPE = { 3: 2, 4: 6 };

/**
 * The bytes of a PNG file of eight bits a channel, of an RGBA frame: RGB, or with `channels` 4 its alpha too. Its
 * header may claim another size.
 *
 * @param {{data: Uint8ClampedArray, width: number, height: number}} frame
 */
export function pngBytes({ data, width, height }, { channels = 3, claim = [width, height] } = {}) {
  const stride = 1 + channels * width;
  const rows = Buffer.alloc(height * stride);
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const pixel = 4 * (y * width + x);
      rows.set(data.subarray(pixel, pixel + channels), y * stride + 1 + channels * x);
    }
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(claim[0], 0);
  header.writeUInt32BE(claim[1], 4);
  header.set([8, COLOR_TYPE[channels], 0, 0, 0], 8);
  const magic = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  return Buffer.concat([
    magic,
    chunk('IHDR', header),
    chunk('IDAT', deflateSync(rows)),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

/** The parts of a PNG file in their order, read strictly: checksums, lengths, and the end. */
export function pngParts(bytes) {
  const file = Buffer.from(bytes);
  if (file.toString('latin1', 0, 8) !== '\x89PNG\r\n\x1a\n') throw new Error('no PNG file');
  const parts = [];
  for (let at = 8; at < file.length;) {
    const length = file.readUInt32BE(at);
    const body = file.subarray(at + 4, at + 8 + length);
    const type = body.toString('latin1', 0, 4);
    if (file.readUInt32BE(at + 8 + length) !== crc32(body)) throw new Error(`checksum of ${type}`);
    parts.push({ type, data: Uint8Array.from(body.subarray(4)) });
    at += length + 12;
  }
  if (parts.findIndex(({ type }) => type === 'IEND') !== parts.length - 1) throw new Error('no end');
  return parts;
}

/** Predictions of a row's filter from the pixels to the left, above, and above left. */
const PREDICTIONS = [
  () => 0,
  (west) => west,
  (west, north) => north,
  (west, north) => (west + north) >> 1,
  (west, north, corner) => {
    const [a, b, c] = [north - corner, west - corner, west + north - 2 * corner].map(Math.abs);
    return a <= b && a <= c ? west : b <= c ? north : corner;
  },
];

/** A PNG file of one byte a pixel. */
export function readPng(bytes) {
  const parts = pngParts(bytes);
  const order = parts.map(({ type }) => type).join(' ');
  const { IHDR, PLTE = null, tRNS = null } = Object.fromEntries(parts.map(({ type, data }) => [type, data]));
  const [width, height] = [Buffer.from(IHDR).readUInt32BE(0), Buffer.from(IHDR).readUInt32BE(4)];
  const rows = inflateSync(Buffer.concat(parts.filter(({ type }) => type === 'IDAT').map(({ data }) => data)));
  if (rows.length !== height * (width + 1)) throw new Error(`${rows.length} bytes of rows`);
  const pixels = new Uint8Array(width * height);
  for (let y = 0; y < height; y += 1) {
    const guess = PREDICTIONS[rows[y * (width + 1)]];
    for (let x = 0, p = y * width; x < width; x += 1, p += 1) {
      const [west, north] = [x > 0 ? pixels[p - 1] : 0, y > 0 ? pixels[p - width] : 0];
      pixels[p] = rows[p + y + 1] + guess(west, north, x > 0 && y > 0 ? pixels[p - width - 1] : 0);
    }
  }
  return { width, height, depth: IHDR[8], colorType: IHDR[9], order, palette: PLTE, alpha: tRNS, pixels };
}

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const bytes = Buffer.alloc(body.length + 8);
  bytes.writeUInt32BE(data.length, 0);
  body.copy(bytes, 4);
  bytes.writeUInt32BE(crc32(body), body.length + 4);
  return bytes;
}

/** The checksum of PNG; Node's own came after version 20. */
export function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit += 1) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return ~crc >>> 0;
}
