// What takes long of PNG files and archives, in the thread that it is called in.

import { zipSync, zlibSync } from '../vendor/zip.js';
import { pixelChunk } from './png.js';

/**
 * The pixels of a PNG file, or files that become an archive. `level` is how hard to try, 0 to 9.
 * @typedef {{kind: 'pixels', pixels: import('./png.js').Pixels, level: 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9}
 *   | {kind: 'zip', files: Record<string, Uint8Array>, stored: string[]}} ZipTask
 */

/** The first date that ZIP knows, in local time, as ZIP has it. */
export const ZIP_DATE = [1980, 0, 1];

/**
 * @param {ZipTask} task
 * @returns {Uint8Array<ArrayBuffer>} a chunk of a PNG file, or an archive
 */
export function zipHere(task) {
  if (task.kind === 'pixels') return pixelChunk(task.pixels, (data) => zlibSync(data, { level: task.level }));
  const stored = new Set(task.stored);
  /** @type {import('fflate').Zippable} */
  const files = {};
  for (const [name, bytes] of Object.entries(task.files)) files[name] = [bytes, { level: stored.has(name) ? 0 : 6 }];
  return zipSync(files, { mtime: new Date(ZIP_DATE[0] ?? 0, 0, 1) });
}
