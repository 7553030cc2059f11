// WebM and Matroska files that were cut off. Readers leave out a cluster that is not whole, and with it up to some
// seconds of frames; here the file is made to end after its last whole block. The elements and their sizes are those of
// EBML (RFC 8794) and Matroska (RFC 9559).

const EBML = 0x1a45dfa3;
const SEGMENT = 0x18538067;
const CLUSTER = 0x1f43b675;

/** Most bytes of small elements in a cluster, by their names: Timestamp, PrevSize, Position, CRC-32. */
const SMALL = new Map([
  [0xe7, 8],
  [0xab, 8],
  [0xa7, 8],
  [0xbf, 4],
]);

/** Bytes of an element's name and size, at most, and of what is read at once to find the next ones. */
const MOST_HEADER = 12;
const CHUNK = 2 ** 20;

/** `end` is `Infinity` where the size is not said. */
export type Element = { id: number; sizeAt: number; sizeLength: number; body: number; end: number };

/** Files that were looked at: a page opens the same one for each picture that it shows. */
const looked = new WeakMap<Blob, Promise<Blob | null>>();

/**
 * The part of a file before its cut, or before damage in the order of its elements: each of them is looked at.
 * @returns a file of its own; null where all is whole, and for other files
 */
export function beforeCut(file: Blob): Promise<Blob | null> {
  const known = looked.get(file) ?? partBefore(file);
  looked.set(file, known);
  known.catch(() => looked.delete(file));
  return known;
}

async function partBefore(file: Blob) {
  const elements = new Elements(file);
  const segment = await elements.segment();
  if (!segment) return null;
  const end = Math.min(file.size, segment.end);
  for (let at = segment.body; at < end;) {
    const child = await elements.at(at);
    const isWhole = child && (child.end <= file.size || child.end === Infinity);
    const isCluster = child?.id === CLUSTER && child.end < Infinity;
    if (!isWhole || (isCluster && (await blocksEnd(elements, child)) < child.end))
      return endingAt(elements, segment, at, child);
    // A cluster of unknown size, as browsers record, ends where the next begins.
    at = child.end < Infinity ? child.end : child.body;
  }
  return segment.end < Infinity && segment.end > file.size ? endingAt(elements, segment, file.size, null) : null;
}

/**
 * The size that a file says it has.
 * @param head its first bytes
 * @returns 0 where it does not say
 */
export async function declaredBytes(head: Blob): Promise<number> {
  const { end = 0 } = (await new Elements(head).segment()) ?? {};
  return end < Infinity ? end : 0;
}

/** @param at where the first element that is not whole begins */
async function endingAt(elements: Elements, segment: Element, at: number, cut: Element | null) {
  const { file } = elements;
  const parts = [file.slice(0, segment.sizeAt), unknownSize(segment.sizeLength), file.slice(segment.body, at)];
  if (cut?.id === CLUSTER) {
    const end = await blocksEnd(elements, cut);
    parts.push(file.slice(at, cut.sizeAt), sizeOf(end - cut.body, cut.sizeLength), file.slice(cut.body, end));
  }
  return new Blob(parts, { type: file.type });
}

/** Where the whole blocks of a cluster end. */
async function blocksEnd(elements: Elements, cluster: Element) {
  const most = Math.min(cluster.end, elements.file.size);
  let end = cluster.body;
  while (end < most) {
    const block = await elements.at(end);
    if (!block || block.end > most || block.end - block.body > (SMALL.get(block.id) ?? Infinity)) break;
    end = block.end;
  }
  return end;
}

/** The elements of a file, read a chunk at a time. */
class Elements {
  chunk = { at: 0, bytes: new Uint8Array(0) };

  constructor(readonly file: Blob) {}

  /** The segment, after the header of the format; null in other files. */
  async segment() {
    const head = await this.at(0);
    const segment = head?.id === EBML ? await this.at(head.end) : null;
    return segment?.id === SEGMENT ? segment : null;
  }

  /** Reads an element; null where the file ends before its header does. */
  async at(at: number): Promise<Element | null> {
    const bytes = await this.#bytes(at);
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

  async #bytes(at: number) {
    const { chunk, file } = this;
    if (at < chunk.at || at + MOST_HEADER > chunk.at + chunk.bytes.length)
      this.chunk = { at, bytes: new Uint8Array(await file.slice(at, at + CHUNK).arrayBuffer()) };
    const from = at - this.chunk.at;
    return this.chunk.bytes.subarray(from, from + MOST_HEADER);
  }
}

/** The first byte says how many there are, by its leading zeros. */
function lengthOf(first = 0) {
  return Math.clz32(first) - 23;
}

/** @param length in bytes */
function unknownSize(length: number) {
  const bytes = new Uint8Array(length).fill(0xff);
  bytes[0] = 0xff >> (length - 1);
  return bytes;
}

/** @param length in bytes */
function sizeOf(size: number, length: number) {
  const bytes = new Uint8Array(length);
  for (let k = length - 1, left = size; k >= 0; k -= 1, left = Math.floor(left / 256)) bytes[k] = left % 256;
  bytes[0] = Number(bytes[0]) | (0x100 >> length);
  return bytes;
}
