// Performs long tasks on PNG files, archives and pictures, in the calling thread or in a worker of its own.

import { zipSync, zlibSync } from '../vendor/zip.js';
import { reduceVideoFrame } from './frames.js';
import { type PngPixels, encodePixels, reducePixels } from './pixels.js';
import type { Zippable } from 'fflate';

/**
 * A task: encoding the pixels of a PNG file, packing an archive, or reducing a picture or a video frame. `level` is the
 * compression level, 0 to 9.
 */
export type AsideTask =
  | { kind: 'pixels'; pixels: PngPixels; level: 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9 }
  | { kind: 'zip'; files: Record<string, Uint8Array>; stored: string[] }
  | {
      kind: 'reduce';
      picture: { data: Uint8Array<ArrayBuffer>; width: number; height: number };
      width: number;
      height: number;
    }
  | { kind: 'frame'; frame: VideoFrame; width: number; height: number };

/** Returns the earliest date that ZIP supports, in local time, as ZIP requires. */
export const createZipDate = () => new Date(1980, 0, 1);

/** Performs a task in this thread. */
export async function performTask(task: AsideTask): Promise<Uint8Array<ArrayBuffer>> {
  if (task.kind === 'pixels') return encodePixels(task.pixels, (data) => zlibSync(data, { level: task.level }));
  if (task.kind === 'frame') {
    const { frame, width, height } = task;
    return reduceVideoFrame(frame, width, height).finally(() => frame.close());
  }
  if (task.kind === 'reduce') return reducePixels(task.picture, task.width, task.height);
  const stored = new Set(task.stored);
  const files: Zippable = {};
  for (const [name, bytes] of Object.entries(task.files)) files[name] = [bytes, { level: stored.has(name) ? 0 : 6 }];
  return zipSync(files, { mtime: createZipDate() });
}

/** Performs the tasks that arrive at `port`; other messages are ignored. */
export function serveAside(
  port: Pick<Worker, 'addEventListener' | 'postMessage'>,
  perform: (task: AsideTask) => Promise<Uint8Array<ArrayBuffer>>,
) {
  port.addEventListener('message', async (event) => {
    const { id, task } = event.data;
    if (!task) return;
    try {
      const bytes = await perform(task);
      port.postMessage({ id, type: 'done', data: bytes }, [bytes.buffer]);
    } catch (error) {
      const message = `the file cannot be made: ${error}`;
      port.postMessage({ id, type: 'failed', data: { code: 'poisoned', message } });
    }
  });
}
