// Decides how the files that a user opens make a clip: one video, or images in the order of their names.

import { sortFiles } from './library.js';
import { PageError } from './messages.js';

/** Files of one clip; `type` is the media type of the first. */
export type ClipFiles = { kind: 'video' | 'images'; files: File[]; type: string };

/** Sorts files by their names and rejects those that make no clip. */
export async function sortClipFiles(files: File[]): Promise<ClipFiles> {
  const sorted = await sortFiles(files);
  const unknown = sorted.find(({ kind }) => kind === null)?.file;
  if (sorted.length === 0 || unknown) throw new PageError('unknown-file', describeUnknown(unknown));
  const areImages = sorted.every(({ kind }) => kind === 'image');
  if (!areImages && sorted.length > 1) {
    const code = sorted.some(({ kind }) => kind === 'image') ? 'mixed-files' : 'many-videos';
    throw new PageError(code, `${sorted.length} files`);
  }
  return { kind: areImages ? 'images' : 'video', files: sorted.map(({ file }) => file), type: sorted[0].type ?? '' };
}

function describeUnknown(file?: File): string {
  if (!file) return '';
  return file.size === 0 ? `${file.name} is empty` : file.name;
}
