// What takes long of PNG files, archives and pictures, in the thread that it is called in, and in a worker of its own.

import { zipSync, zlibSync } from '../vendor/zip.js';
import { fromImage } from './frames.js';
import { type Pixels, pixelChunk, reduced } from './pixels.js';
import type { Zippable } from 'fflate';

/**
 * The pixels of a PNG file, or files that become an archive, or a picture or a video's frame that is to have fewer
 * pixels. `level` is how hard to try, 0 to 9.
 */
export type AsideTask =
  | { kind: 'pixels'; pixels: Pixels; level: 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9 }
  | { kind: 'zip'; files: Record<string, Uint8Array>; stored: string[] }
  | {
      kind: 'reduce';
      picture: { data: Uint8Array<ArrayBuffer>; width: number; height: number };
      width: number;
      height: number;
    }
  | { kind: 'frame'; frame: VideoFrame; width: number; height: number };

/** The first date that ZIP knows, in local time, as ZIP has it. */
export const zipDate = () => new Date(1980, 0, 1);

/** Returns a chunk of a PNG file, an archive, or pixels. */
export async function doHere(task: AsideTask): Promise<Uint8Array<ArrayBuffer>> {
  if (task.kind === 'pixels') return pixelChunk(task.pixels, (data) => zlibSync(data, { level: task.level }));
  if (task.kind === 'frame') return pixelsOf(task.frame, task.width, task.height);
  if (task.kind === 'reduce') return reduced(task.picture, task.width, task.height);
  const stored = new Set(task.stored);
  const files: Zippable = {};
  for (const [name, bytes] of Object.entries(task.files)) files[name] = [bytes, { level: stored.has(name) ? 0 : 6 }];
  return zipSync(files, { mtime: zipDate() });
}

async function pixelsOf(frame: VideoFrame, width: number, height: number) {
  try {
    const raw = await fromImage(frame);
    if (raw.kind !== 'pixels' || (raw.width === width && raw.height === height)) return raw.data;
    return reduced(raw, width, height);
  } finally {
    frame.close();
  }
}

/** Answers the tasks that arrive at `port`; what else arrives there is not for this. */
export function serveAside(
  port: Pick<Worker, 'addEventListener' | 'postMessage'>,
  doTask: (task: AsideTask) => Promise<Uint8Array<ArrayBuffer>>,
) {
  port.addEventListener('message', async (event) => {
    const { id, task } = event.data;
    if (!task) return;
    try {
      const bytes = await doTask(task);
      port.postMessage({ id, type: 'done', data: bytes }, [bytes.buffer]);
    } catch (error) {
      const message = `the file cannot be made: ${error}`;
      port.postMessage({ id, type: 'failed', data: { code: 'poisoned', message } });
    }
  });
}
