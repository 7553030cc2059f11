// WebM and Matroska files that were cut off. Readers leave out a cluster that is not whole, and with it up to some
// seconds of frames; here the file is made to end after its last whole block. The elements and their sizes are those of
// EBML (RFC 8794) and Matroska (RFC 9559).

const EBML = 0x1a45dfa3;
const SEGMENT = 0x18538067;
const CLUSTER = 0x1f43b675;

/** Bytes of an element's name and size, at most. */
const MOST_HEADER = 12;

/**
 * @typedef {{id: number, sizeAt: number, sizeLength: number, body: number, end: number}} Element `end` is `Infinity` where
 *   the size is not said
 */

/**
 * @param {Blob} file
 * @returns {Promise<Blob | null>} the part before the cut as a file of its own; null where nothing was cut off, and for
 *   other files
 */
export async function beforeCut(file) {
  const head = await elementAt(file, 0);
  if (head?.id !== EBML) return null;
  const segment = await elementAt(file, head.end);
  if (segment?.id !== SEGMENT) return null;
  for (let at = segment.body; at < file.size;) {
    const child = await elementAt(file, at);
    // A cluster of unknown size goes on to wherever the file ends.
    if (child?.end === Infinity) return null;
    if (!child || child.end > file.size) return endingAt(file, segment, at, child);
    at = child.end;
  }
  return segment.end !== Infinity && segment.end > file.size ? endingAt(file, segment, file.size, null) : null;
}

/**
 * @param {Blob} file
 * @param {Element} segment
 * @param {number} at where the first element that is not whole begins
 * @param {Element | null} cut that element
 */
async function endingAt(file, segment, at, cut) {
  const parts = [file.slice(0, segment.sizeAt), unknownSize(segment.sizeLength), file.slice(segment.body, at)];
  if (cut?.id === CLUSTER) {
    let end = cut.body;
    for (;;) {
      const block = await elementAt(file, end);
      if (!block || block.end > file.size) break;
      end = block.end;
    }
    parts.push(file.slice(at, cut.sizeAt), sizeOf(end - cut.body, cut.sizeLength), file.slice(cut.body, end));
  }
  return new Blob(parts, { type: file.type });
}

/**
 * @param {Blob} file
 * @param {number} at
 * @returns {Promise<Element | null>} null where the file ends before its header does
 */
async function elementAt(file, at) {
  const bytes = new Uint8Array(await file.slice(at, at + MOST_HEADER).arrayBuffer());
  const idLength = lengthOf(bytes[0]);
  const sizeLength = lengthOf(bytes[idLength]);
  if (idLength > 4 || sizeLength > 8 || bytes.length < idLength + sizeLength) return null;
  const id = bytes.subarray(0, idLength).reduce((value, byte) => 256 * value + byte, 0);
  const [first = 0, ...rest] = bytes.subarray(idLength, idLength + sizeLength);
  const lead = first & (0xff >> sizeLength);
  const unknown = lead === 0xff >> sizeLength && rest.every((byte) => byte === 0xff);
  const size = unknown ? Infinity : rest.reduce((value, byte) => 256 * value + byte, lead);
  const body = at + idLength + sizeLength;
  return { id, sizeAt: at + idLength, sizeLength, body, end: body + size };
}

/**
 * The first byte says how many there are, by its leading zeros.
 * @param {number} [first]
 */
function lengthOf(first = 0) {
  return Math.clz32(first) - 23;
}

/** @param {number} length in bytes */
function unknownSize(length) {
  const bytes = new Uint8Array(length).fill(0xff);
  bytes[0] = 0xff >> (length - 1);
  return bytes;
}

/**
 * @param {number} size
 * @param {number} length in bytes
 */
function sizeOf(size, length) {
  const bytes = new Uint8Array(length);
  for (let k = length - 1, left = size; k >= 0; k -= 1, left = Math.floor(left / 256)) bytes[k] = left % 256;
  bytes[0] = Number(bytes[0]) | (0x100 >> length);
  return bytes;
}
