// Detects the kind of a file by its first bytes, as extensions, and the types that systems derive from them, are often missing or wrong.

/** Number of bytes inspected: a transport stream is detected by the sync bytes of three packets of up to 204 bytes. */
const HEAD_BYTES = 512;

/** Kind of a file, and media type of its content. */
export type FileKind = { readonly kind: 'video' | 'image'; readonly type: string };

/** First bytes of formats, one character each. */
const FORMATS: { kind: 'video' | 'image'; type: string; begins: RegExp }[] = [
  { kind: 'image', type: 'image/gif', begins: /^GIF8/ },
  { kind: 'image', type: 'image/png', begins: /^\x89PNG/ },
  { kind: 'image', type: 'image/jpeg', begins: /^\xff\xd8\xff/ },
  { kind: 'image', type: 'image/webp', begins: /^RIFF.{4}WEBP/s },
  { kind: 'image', type: 'image/avif', begins: /^.{4}ftyp(?:avi[fs]|mi[af]1.{0,32}avi[fs]|msf1.{0,32}avi[fs])/s },
  { kind: 'image', type: 'image/heic', begins: /^.{4}ftyp(?:hei[cmsx]|hev[cmsx]|mif1|msf1)/s },
  { kind: 'image', type: 'image/bmp', begins: /^BM.{4}\0{4}/s },
  { kind: 'image', type: 'image/tiff', begins: /^(?:II\*\0|MM\0\*)/ },
  { kind: 'video', type: 'video/quicktime', begins: /^.{4}(?:ftypqt {2}|moov|mdat|wide|free|skip|pnot)/s },
  { kind: 'video', type: 'video/mp4', begins: /^.{4}(?:ftyp|styp|moof|sidx)/s },
  { kind: 'video', type: 'video/webm', begins: /^\x1aE\xdf\xa3.{0,40}webm/s },
  { kind: 'video', type: 'video/matroska', begins: /^\x1aE\xdf\xa3/ },
  { kind: 'video', type: 'video/mp2t', begins: /^(?:G.{187}G.{187}G|.{4}G.{191}G.{191}|G.{203}G.{203}G)/s },
  { kind: 'video', type: 'video/ogg', begins: /^OggS/ },
  { kind: 'video', type: 'video/mpeg', begins: /^\0\0\x01[\xb3\xba]/ },
  { kind: 'video', type: 'video/x-msvideo', begins: /^RIFF.{4}AVI /s },
  { kind: 'video', type: 'video/x-flv', begins: /^FLV\x01/ },
  { kind: 'video', type: 'video/x-ms-wmv', begins: /^0&\xb2u\x8ef\xcf\x11/ },
];

/** Detects the kind of a file; null if it is neither a video nor an image, or cannot be read. */
export async function detectKind(file: Blob): Promise<FileKind | null> {
  const bytes = await file
    .slice(0, HEAD_BYTES)
    .arrayBuffer()
    .catch(() => new ArrayBuffer(0));
  const head = String.fromCharCode(...new Uint8Array(bytes));
  const format = FORMATS.find(({ begins }) => begins.test(head));
  return format ? { kind: format.kind, type: format.type } : null;
}

/** A file chosen by a user; `kind` and `type` are null if it is neither a video nor an image. */
export type SortedFile = { readonly file: File; readonly kind: 'video' | 'image' | null; readonly type: string | null };

/**
 * Sorts files chosen by a user in natural order of their names (`IMG_2` before `img_10`), and detects the kind of each by
 * its content. Hidden files beside others, such as `._clip.mp4`, are dropped. A file that is listed may still be
 * undecodable.
 *
 * ```js
 * const [{ file, kind, type }] = await sortFiles(input.files); // such as 'video', 'video/mp2t'
 * ```
 */
export async function sortFiles(files: Iterable<File>): Promise<SortedFile[]> {
  const allFiles = [...files];
  const visible = allFiles.length > 1 ? allFiles.filter(({ name }) => !name.startsWith('.')) : allFiles;
  visible.sort((a, b) => compareNames(a.name, b.name));
  return Promise.all(
    visible.map(async (file) => ({ file, ...((await detectKind(file)) ?? { kind: null, type: null }) })),
  );
}

/**
 * Compares file names in natural order: digits by their value, letters regardless of case (`IMG_2` before `img_10`), then
 * by the exact name; independent of the machine's language. For `sort`.
 * @returns below 0 if `a` comes first, above 0 if `b` does
 */
export function compareNames(a: string, b: string): number {
  const [first, second] = [split(a), split(b)];
  for (let k = 0; k < Math.min(first.length, second.length); k += 1) {
    const difference = compareParts(String(first[k]), String(second[k]));
    if (difference !== 0) return difference;
  }
  return first.length - second.length || compareText(a, b);
}

/** Splits a name into numbers and single other characters. */
const split = (name: string) => name.toLowerCase().match(/\d+|\D/gu) ?? [];

function compareParts(a: string, b: string) {
  if (!/^\d/.test(a) || !/^\d/.test(b)) return compareText(a, b);
  const [first, second] = [a, b].map((digits) => digits.replace(/^0+(?=\d)/, ''));
  return Number(first?.length) - Number(second?.length) || compareText(String(first), String(second));
}

const compareText = (a: string, b: string) => (a < b ? -1 : Number(a > b));
