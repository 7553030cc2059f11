// Frames that lie as image files in a folder: which files are frames, and their order.

import { TraceCutError, illegal, typeTag } from '../errors.js';

/**
 * A frame of a folder, as `segmentVideo` and `videoFrames` take it: the bytes or the file, and its name.
 * @typedef {object} FrameFile
 * @property {Uint8Array<ArrayBuffer> | File} frame
 * @property {string} name of the file
 */

/** What is read by the name's ending, and what looks like a picture but cannot be read. */
const FRAME = /\.(png|jpe?g)$/i;
const PICTURE = /\.(webp|gif|bmp|tiff?|avif|heic|p[pgn]m|exr)$/i;

/**
 * The names of frames, in their order: numbers in them count as numbers, so that frame2 comes before frame10. Hidden
 * files and what is no picture are left out.
 * @param {readonly string[]} names of the files of a folder
 * @param {string} folder what it is called, for errors
 * @returns {string[]}
 */
export function frameNames(names, folder) {
  const seen = names.filter((name) => !name.startsWith('.'));
  const foreign = seen.find((name) => PICTURE.test(name));
  if (foreign !== undefined) throw illegal('data', 'a frame', foreign, 'the name of a PNG or JPEG file');
  const frames = seen.filter((name) => FRAME.test(name)).sort(byNumbers);
  if (frames.length > 0) return frames;
  const there = seen.length > 0 ? `only ${seen.slice(0, 3).join(', ')}` : 'nothing';
  throw new TraceCutError('no-frames', `${folder} has no PNG or JPEG files; there is ${there}`);
}

/**
 * By the same rule everywhere, whatever the language of the machine.
 * @param {string} a
 * @param {string} b
 */
function byNumbers(a, b) {
  const [first, second] = [partsOf(a), partsOf(b)];
  for (let k = 0; k < Math.min(first.length, second.length); k += 1) {
    const order = compared(String(first[k]), String(second[k]));
    if (order !== 0) return order;
  }
  return first.length - second.length || order(a, b);
}

/** Numbers, and the other letters one by one. @param {string} name */
const partsOf = (name) => name.match(/\d+|\D/g) ?? [];

/**
 * @param {string} a
 * @param {string} b
 */
function compared(a, b) {
  if (!/^\d/.test(a) || !/^\d/.test(b)) return order(a, b);
  const [first, second] = [a, b].map((digits) => digits.replace(/^0+(?=\d)/, ''));
  return Number(first?.length) - Number(second?.length) || order(String(first), String(second));
}

/**
 * @param {string} a
 * @param {string} b
 */
const order = (a, b) => (a < b ? -1 : Number(a > b));

/**
 * The frames that lie as PNG or JPEG files in a folder, in the order of the numbers in their names (frame2 before
 * frame10), one read at a time. Hidden files and what is no picture are left out. In Node a folder is its path; a page
 * gives the files that a user chose.
 *
 * ```js
 * for await (const window of segmentVideo(readFrames('frames'), { frameRate: 30 })) console.log(window.objects);
 * ```
 * @param {string | URL | Iterable<File>} folder its path or `file:` address, or its files
 * @returns {AsyncGenerator<FrameFile, void, undefined>} for `segmentVideo`; errors of one
 *   that cannot be decoded say its name
 * @throws {TraceCutError} `no-frames` where the folder has no such file, `data` where a frame is in another format
 */
export async function* readFrames(folder) {
  if (typeof folder === 'string' || typeTag(folder) === 'URL') {
    const hint = 'pass the files themselves, as `<input type="file" webkitdirectory>` gives them';
    throw new TraceCutError('unsupported', `a page cannot read folders by name; ${hint}`);
  }
  if (typeof folder !== 'object' || folder === null || !(Symbol.iterator in folder))
    throw illegal('data', 'folder', folder, 'the name of a folder (in Node), or a list of files');
  /** @type {Map<string, File>} */
  const byName = new Map();
  for (const file of folder) {
    if (typeTag(file) !== 'File') throw illegal('data', 'a file of the folder', file, 'a File');
    if (byName.has(file.name)) throw illegal('data', 'a file of the folder', file.name, 'files of different names');
    byName.set(file.name, file);
  }
  for (const name of frameNames([...byName.keys()], 'the list of files'))
    yield { frame: /** @type {File} */ (byName.get(name)), name };
}
