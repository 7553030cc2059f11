// Kinds of files by their first bytes: endings, and the types that systems make of them, are often missing or wrong.

/** Bytes that are looked at: a transport stream shows in the sync bytes of three packets of up to 204 bytes. */
const HEAD_BYTES = 512;

/** The kind of a file, and the media type that its content has. */
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

/** Finds the kind of a file; null for what is neither a video nor an image, and for what cannot be read. */
export async function fileKind(file: Blob): Promise<FileKind | null> {
  const bytes = await file
    .slice(0, HEAD_BYTES)
    .arrayBuffer()
    .catch(() => new ArrayBuffer(0));
  const head = String.fromCharCode(...new Uint8Array(bytes));
  const found = FORMATS.find(({ begins }) => begins.test(head));
  return found ? { kind: found.kind, type: found.type } : null;
}

/** A file that a user chose; `kind` and `type` are null where it is neither a video nor an image. */
export type SortedFile = { readonly file: File; readonly kind: 'video' | 'image' | null; readonly type: string | null };

/**
 * Sorts files that a user chose by their names, as a person would (`IMG_2` before `img_10`), and finds the kind of each by
 * its content, whatever it is called. Hidden files beside others, such as `._clip.mp4`, are left out. Whether a file can
 * be decoded is another question.
 *
 * ```js
 * const [{ file, kind, type }] = await sortFiles(input.files); // such as 'video', 'video/mp2t'
 * ```
 */
export async function sortFiles(files: Iterable<File>): Promise<SortedFile[]> {
  const all = [...files];
  const shown = all.length > 1 ? all.filter(({ name }) => !name.startsWith('.')) : all;
  shown.sort((a, b) => compareNames(a.name, b.name));
  return Promise.all(shown.map(async (file) => ({ file, ...((await fileKind(file)) ?? { kind: null, type: null }) })));
}

/**
 * Orders names of files as a person would: digits by their value, letters whatever their case (`IMG_2` before `img_10`),
 * then by the exact name; the same everywhere, whatever the language of the machine. For `sort`.
 * @returns below 0 where `a` comes first, above 0 where `b` does
 */
export function compareNames(a: string, b: string): number {
  const [first, second] = [partsOf(a), partsOf(b)];
  for (let k = 0; k < Math.min(first.length, second.length); k += 1) {
    const found = compared(String(first[k]), String(second[k]));
    if (found !== 0) return found;
  }
  return first.length - second.length || order(a, b);
}

/** Numbers, and the other letters one by one. */
const partsOf = (name: string) => name.toLowerCase().match(/\d+|\D/gu) ?? [];

function compared(a: string, b: string) {
  if (!/^\d/.test(a) || !/^\d/.test(b)) return order(a, b);
  const [first, second] = [a, b].map((digits) => digits.replace(/^0+(?=\d)/, ''));
  return Number(first?.length) - Number(second?.length) || order(String(first), String(second));
}

const order = (a: string, b: string) => (a < b ? -1 : Number(a > b));
