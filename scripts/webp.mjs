// Puts still WebP pictures together to a moving one: the container alone, the pictures stay as they are encoded.

/**
 * @param {Buffer[]} frames WebP files of one size, lossy and without alpha
 * @param {number} milliseconds that each is shown; it begins again after the last
 * @returns {Buffer} the file
 */
export function animatedWebp(frames, milliseconds) {
  const images = frames.map(bitstream);
  // The size of a key frame stands after its tag of three bytes and its start code of three.
  const [width, height] = [images[0].readUInt16LE(14) & 0x3fff, images[0].readUInt16LE(16) & 0x3fff];
  const header = Buffer.alloc(10);
  header[0] = 2; // animated
  header.writeUIntLE(width - 1, 4, 3);
  header.writeUIntLE(height - 1, 7, 3);
  const looped = Buffer.from([255, 255, 255, 255, 0, 0]);
  const shown = images.map((image) => {
    const frame = Buffer.alloc(16);
    frame.writeUIntLE(width - 1, 6, 3);
    frame.writeUIntLE(height - 1, 9, 3);
    frame.writeUIntLE(milliseconds, 12, 3);
    frame[15] = 2; // replaces what was there
    return chunk('ANMF', Buffer.concat([frame, image]));
  });
  return chunk('RIFF', Buffer.concat([Buffer.from('WEBP'), chunk('VP8X', header), chunk('ANIM', looped), ...shown]));
}

/** The chunk with the picture of a WebP file, with its header. */
function bitstream(file) {
  for (let at = 12; at < file.length;) {
    const size = file.readUInt32LE(at + 4);
    if (file.toString('latin1', at, at + 4) === 'VP8 ') return file.subarray(at, at + 8 + size + (size & 1));
    at += 8 + size + (size & 1);
  }
  throw new Error('a frame is no lossy WebP picture');
}

function chunk(name, data) {
  const head = Buffer.alloc(8);
  head.write(name, 'latin1');
  head.writeUInt32LE(data.length, 4);
  return Buffer.concat([head, data, Buffer.alloc(data.length & 1)]);
}
