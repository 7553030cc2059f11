// `tracecut` in Node: as in browsers, and folders can be read by path.

import { readFile, readdir } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { TraceCutError } from '../check/errors.js';
import { type FrameFile, readFrames as framesOfFiles, sortFrameNames } from '../video/frame-list.js';
import './platform.js';

export * from '../index.js';

/** Reads the PNG and JPEG files of a folder, given by its path or its files, as frames in the order of their names. */
export async function* readFrames(folder: string | URL | Iterable<File>): AsyncGenerator<FrameFile, void, undefined> {
  if (typeof folder !== 'string' && !(folder instanceof URL)) {
    yield* framesOfFiles(folder);
    return;
  }
  const path = typeof folder === 'string' ? folder : fileURLToPath(folder);
  for (const name of sortFrameNames(await listFiles(path), `the folder ${basename(path)}`))
    yield { frame: new Uint8Array(await readFile(join(path, name))), name };
}

async function listFiles(path: string) {
  try {
    const entries = await readdir(path, { withFileTypes: true });
    return entries.filter((entry) => !entry.isDirectory()).map(({ name }) => name);
  } catch (cause) {
    throw new TraceCutError('no-frames', `the folder ${path} cannot be read: ${String(cause)}`, { cause });
  }
}
