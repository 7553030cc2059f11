// The masks of several clips in one archive.

import { aside } from '../aside/aside.js';
import { checkedOptions, describe, illegal } from '../errors.js';
import { VERSION } from '../parameters.js';
import { Encoder } from '../text.js';
import { filesOfMasks } from './masks.js';

/** @typedef {import('./mask-source.js').MaskSource} MaskSource */

/**
 * A clip of the archive: its masks, or the error for which there are none.
 * @typedef {object} ZippedClip
 * @property {string} name what its folder is called after
 * @property {MaskSource | null} masks null where there are none
 * @property {unknown} [error] why there are none
 * @property {Record<string, unknown>} [about] the caller's own, for the report
 */

/**
 * As of `masksZip`; `onProgress` counts the frames of all clips.
 * @typedef {Omit<import('./masks.js').MasksZipOptions, 'objects'>} ClipsZipOptions
 */

/**
 * The masks of several clips in one ZIP archive: a folder for each, with what `masksZip` puts into one, and
 * `report.json`, which says what became of each. The same masks give the same bytes.
 * @param {ZippedClip[]} clips
 * @param {ClipsZipOptions} [options]
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the bytes of the archive
 */
export async function clipsZip(clips, options = {}) {
  if (!Array.isArray(clips)) throw illegal('data', 'clips', clips, 'a list of {name, masks}');
  const legal = ['perObject', 'palette', 'transparent', 'frameRate', 'onProgress', 'signal'];
  const { onProgress, ...each } = checkedOptions(options, legal);
  const total = clips.reduce((sum, { masks }) => sum + (masks?.numFrames ?? 0), 0);
  /** @type {Record<string, Uint8Array<ArrayBuffer>>} */
  const files = {};
  const folders = new Set();
  const report = [];
  let before = 0;
  for (const [k, { name, masks, error, about }] of clips.entries()) {
    if (typeof name !== 'string') throw illegal('data', `clips[${k}].name`, name, 'a text');
    if (!masks) {
      report.push({ name, error: wordsOf(error), ...about });
      continue;
    }
    const folder = folderOf(name, folders);
    const done = before;
    const counted = (/** @type {{done: number}} */ progress) => onProgress?.({ done: done + progress.done, total });
    const made = await filesOfMasks(masks, { ...each, onProgress: counted });
    for (const [path, bytes] of Object.entries(made)) files[`${folder}/${path}`] = bytes;
    before += masks.numFrames;
    const { width, height, numFrames } = masks;
    report.push({ name, folder, width, height, numFrames, ...about });
  }
  const json = JSON.stringify({ generator: 'tracecut', version: VERSION, clips: report }, null, 2);
  files['report.json'] = new Encoder().encode(`${json}\n`);
  // PNG files are compressed already.
  const bytes = Object.values(files).map(({ buffer }) => buffer);
  return aside({ kind: 'zip', files, stored: Object.keys(files) }, bytes);
}

/** @param {unknown} error */
function wordsOf(error) {
  if (error instanceof Error) return 'code' in error ? `${String(error.code)}: ${error.message}` : error.message;
  return error === undefined || error === null ? 'no masks' : describe(error);
}

/**
 * A folder for a clip: what every file system takes, and no other clip has.
 * @param {string} name
 * @param {Set<unknown>} taken
 */
function folderOf(name, taken) {
  const stem = name
    .replace(/\.[a-z0-9]{2,5}$/i, '')
    .replace(/[^\p{L}\p{N}_-]+/gu, '-')
    .replace(/^-+|-+$/g, '')
    .slice(0, 80);
  let folder = stem || 'clip';
  for (let k = 2; taken.has(folder.toLowerCase()); k += 1) folder = `${stem || 'clip'}-${k}`;
  taken.add(folder.toLowerCase());
  return folder;
}
