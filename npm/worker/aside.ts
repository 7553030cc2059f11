// What takes long is done in a worker of its own where there are workers: PNG files, archives, large pictures.

import { TraceCutError } from '../check/errors.js';
import { part } from '../places.js';
import { platform } from '../platform.js';
import { joined, pngHead, pngTail } from './pixels.js';
import { TaskWorkers } from './remote.js';
import type { AsideTask } from './aside-here.js';

const workers = new TaskWorkers(() => 1);
/** Whether no worker can be had: a bundler was not told of it, or a policy forbids it, or it is one for sessions alone. */
let without = false;

/** @param transfer what nobody else holds */
export async function aside(task: AsideTask, transfer: Transferable[] = []): Promise<Uint8Array<ArrayBuffer>> {
  const { startAside } = platform;
  if (!startAside || without) return here(task);
  try {
    // As long as nobody knows whether it runs, the task may have to be done here.
    return await workers.give(startAside, (remote) =>
      remote.send({ task }, { transfer: remote.heard ? transfer : [] }),
    );
  } catch (error) {
    if (!(error instanceof TraceCutError && ['wasm-load', 'state'].includes(error.code))) throw error;
    without = true;
    return here(task);
  }
}

async function here(task: AsideTask) {
  return (await part(import('./aside-here.js'))).doHere(task);
}

/** A PNG file of one channel. */
export async function pngOf({
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
  const data = await aside(task, [pixels.buffer]);
  return joined([pngHead({ width, height, palette, alpha }), data, pngTail()]);
}
