// Animated GIF files of synthetic frames.

/**
 * Returns a file for `setInputFiles`: an animated GIF of grey frames (the red channel of each, halved).
 *
 * @param {string} name
 * @param {{data: Uint8ClampedArray, width: number, height: number}[]} frames
 * @param {number[]} [delays] duration of each frame, in hundredths of a second; 7 if not given
 */
export function gifFile(name, frames, delays = []) {
  const { width, height } = frames[0];
  const size = [width & 255, width >> 8, height & 255, height >> 8];
  const greys = Array.from({ length: 128 }, (_, k) => [2 * k, 2 * k, 2 * k]).flat();
  const loop = [0x21, 0xff, 11, ...Buffer.from('NETSCAPE2.0'), 3, 1, 0, 0, 0];
  const parts = [Buffer.from('GIF89a'), Buffer.from([...size, 0xf6, 0, 0, ...greys, ...loop])];
  for (const [k, { data }] of frames.entries()) {
    const delay = delays[k] ?? 7;
    parts.push(
      Buffer.from([0x21, 0xf9, 4, 0, delay & 255, delay >> 8, 0, 0, 0x2c, 0, 0, 0, 0, ...size, 0, 7]),
      gifCodes(data),
      Buffer.from([0]),
    );
  }
  return { name, mimeType: 'image/gif', buffer: Buffer.concat([...parts, Buffer.from([0x3b])]) };
}

/** Pixels as codes of 8 bits: the table is cleared so often that codes never grow, so nothing is compressed. */
function gifCodes(data) {
  const codes = [];
  for (let k = 0; 4 * k < data.length; k += 1) {
    if (k % 100 === 0) codes.push(128);
    codes.push(data[4 * k] >> 1);
  }
  codes.push(129);
  const blocks = [];
  for (let k = 0; k < codes.length; k += 255) {
    const block = codes.slice(k, k + 255);
    blocks.push(block.length, ...block);
  }
  return Buffer.from(blocks);
}
