// Runs long tasks in a worker of its own, if there are workers: PNG files, archives, large pictures.

import { TraceCutError } from '../check/errors.js';
import { loadPart, platform } from '../platform.js';
import { concatenate, encodeHead, encodeTail } from './pixels.js';
import { TaskWorkers } from './remote.js';
import type { AsideTask } from './aside-here.js';

const workers = new TaskWorkers(() => 1);
/** True if no worker can start: a bundler did not copy it, a policy forbids it, or it serves sessions only. */
let isUnavailable = false;

/** @param transfer buffers that nothing else uses */
export async function runTask(task: AsideTask, transfer: Transferable[] = []): Promise<Uint8Array<ArrayBuffer>> {
  const { startAside } = platform;
  if (!startAside || isUnavailable) return runHere(task);
  try {
    // Until the worker has answered, the task may still have to run here.
    return await workers.give(startAside, (remote) =>
      remote.send({ task }, { transfer: remote.heard ? transfer : [] }),
    );
  } catch (error) {
    if (!(error instanceof TraceCutError && ['wasm-load', 'state'].includes(error.code))) throw error;
    isUnavailable = true;
    return runHere(task);
  }
}

async function runHere(task: AsideTask) {
  return (await loadPart(import('./aside-here.js'))).performTask(task);
}

/** Encodes a PNG file of one channel. */
export async function encodePng({
  pixels,
  width,
  height,
  palette,
  alpha,
}: {
  pixels: Uint8Array<ArrayBuffer>;
  width: number;
  height: number;
  palette?: Uint8Array;
  alpha?: Uint8Array;
}) {
  const task: AsideTask = { kind: 'pixels', level: 6, pixels: { data: pixels, width, height, channels: 1 } };
  const data = await runTask(task, [pixels.buffer]);
  return concatenate([encodeHead({ width, height, palette, alpha }), data, encodeTail()]);
}
