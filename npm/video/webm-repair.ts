// WebM and Matroska files that were cut off. Readers drop an incomplete cluster, and with it up to some seconds of frames;
// this module makes the file end after its last complete block. The elements and their sizes are defined by EBML (RFC 8794)
// and Matroska (RFC 9559).

/** Names of elements. */
const EBML = 0x1a45dfa3;
const SEGMENT = 0x18538067;
const CLUSTER = 0x1f43b675;

/** Largest sizes of small elements in a cluster, in bytes: Timestamp, PrevSize, Position, CRC-32. */
const MAX_SIZES = new Map([
  [0xe7, 8],
  [0xab, 8],
  [0xa7, 8],
  [0xbf, 4],
]);

/** Most bytes of an element's name and size. */
const MAX_HEADER_BYTES = 12;
/** Bytes read at once to find the next elements. */
const CHUNK_BYTES = 2 ** 20;

/** An element; `end` is `Infinity` if its size is unknown. */
export type Element = { id: number; sizeAt: number; sizeLength: number; body: number; end: number };

/** Results by file: a page opens the same file for each picture that it shows. */
const results = new WeakMap<Blob, Promise<Blob | null>>();

/**
 * Returns the part of a file before its cut, or before damage of its structure: all elements are checked.
 * @returns a new file; null if the file is complete, and for other formats
 */
export function repairCut(file: Blob): Promise<Blob | null> {
  const result = results.get(file) ?? findCut(file);
  results.set(file, result);
  result.catch(() => results.delete(file));
  return result;
}

async function findCut(file: Blob) {
  const elements = new Elements(file);
  const segment = await elements.readSegment();
  if (!segment) return null;
  const end = Math.min(file.size, segment.end);
  for (let offset = segment.body; offset < end;) {
    const child = await elements.read(offset);
    const isComplete = child && (child.end <= file.size || child.end === Infinity);
    const isCluster = child?.id === CLUSTER && child.end < Infinity;
    if (!isComplete || (isCluster && (await findBlocksEnd(elements, child)) < child.end))
      return cutAt(elements, segment, offset, child);
    // A cluster of unknown size, as browsers record, ends where the next one begins.
    offset = child.end < Infinity ? child.end : child.body;
  }
  return segment.end < Infinity && segment.end > file.size ? cutAt(elements, segment, file.size, null) : null;
}

/**
 * Returns the size that a file declares.
 * @param head its first bytes
 * @returns 0 if it declares none
 */
export async function readDeclaredBytes(head: Blob): Promise<number> {
  const { end = 0 } = (await new Elements(head).readSegment()) ?? {};
  return end < Infinity ? end : 0;
}

/** @param offset of the first incomplete element */
async function cutAt(elements: Elements, segment: Element, offset: number, cut: Element | null) {
  const { file } = elements;
  const parts = [
    file.slice(0, segment.sizeAt),
    encodeUnknownSize(segment.sizeLength),
    file.slice(segment.body, offset),
  ];
  if (cut?.id === CLUSTER) {
    const end = await findBlocksEnd(elements, cut);
    parts.push(file.slice(offset, cut.sizeAt), encodeSize(end - cut.body, cut.sizeLength), file.slice(cut.body, end));
  }
  return new Blob(parts, { type: file.type });
}

/** Returns the end of the last complete block of a cluster. */
async function findBlocksEnd(elements: Elements, cluster: Element) {
  const limit = Math.min(cluster.end, elements.file.size);
  let end = cluster.body;
  while (end < limit) {
    const block = await elements.read(end);
    if (!block || block.end > limit || block.end - block.body > (MAX_SIZES.get(block.id) ?? Infinity)) break;
    end = block.end;
  }
  return end;
}

/** Reads the elements of a file, a chunk at a time. */
class Elements {
  chunk = { at: 0, bytes: new Uint8Array(0) };

  constructor(readonly file: Blob) {}

  /** Returns the segment, which follows the format's header; null in other files. */
  async readSegment() {
    const head = await this.read(0);
    const segment = head?.id === EBML ? await this.read(head.end) : null;
    return segment?.id === SEGMENT ? segment : null;
  }

  /** Reads an element; null if the file ends before its header does. */
  async read(offset: number): Promise<Element | null> {
    const bytes = await this.#readHeader(offset);
    const idLength = readLength(bytes[0]);
    const sizeLength = readLength(bytes[idLength]);
    if (idLength > 4 || sizeLength > 8 || bytes.length < idLength + sizeLength) return null;
    const id = bytes.subarray(0, idLength).reduce((value, byte) => 256 * value + byte, 0);
    const [first = 0, ...rest] = bytes.subarray(idLength, idLength + sizeLength);
    const lead = first & (0xff >> sizeLength);
    const isUnknown = lead === 0xff >> sizeLength && rest.every((byte) => byte === 0xff);
    const size = isUnknown ? Infinity : rest.reduce((value, byte) => 256 * value + byte, lead);
    const body = offset + idLength + sizeLength;
    return { id, sizeAt: offset + idLength, sizeLength, body, end: body + size };
  }

  async #readHeader(offset: number) {
    const { chunk, file } = this;
    if (offset < chunk.at || offset + MAX_HEADER_BYTES > chunk.at + chunk.bytes.length)
      this.chunk = { at: offset, bytes: new Uint8Array(await file.slice(offset, offset + CHUNK_BYTES).arrayBuffer()) };
    const from = offset - this.chunk.at;
    return this.chunk.bytes.subarray(from, from + MAX_HEADER_BYTES);
  }
}

/** Returns the length of a number, which its first byte encodes by its leading zeros. */
function readLength(first = 0) {
  return Math.clz32(first) - 23;
}

/** @param length in bytes */
function encodeUnknownSize(length: number) {
  const bytes = new Uint8Array(length).fill(0xff);
  bytes[0] = 0xff >> (length - 1);
  return bytes;
}

/** @param length in bytes */
function encodeSize(size: number, length: number) {
  const bytes = new Uint8Array(length);
  for (let k = length - 1, rest = size; k >= 0; k -= 1, rest = Math.floor(rest / 256)) bytes[k] = rest % 256;
  bytes[0] = Number(bytes[0]) | (0x100 >> length);
  return bytes;
}
