// What takes long is done in a worker of its own where there are workers: PNG files, archives, large pictures.

import { TraceCutError } from '../check/errors.js';
import { part } from '../places.js';
import { platform } from '../platform.js';
import { joined, pngHead, pngTail } from './pixels.js';

/** @typedef {import('./aside-here.js').AsideTask} AsideTask */

/** How long a worker stays that has nothing to do, in milliseconds: frames come one after the other. */
const IDLE_MS = 5000;

/**
 * @typedef {{task: AsideTask, resolve: (bytes: Uint8Array<ArrayBuffer> | Promise<Uint8Array<ArrayBuffer>>) => void, reject:
 *   (error: unknown) => void}} Waiting
 */

/** `heard` once it has answered. @typedef {{worker: Worker, waiting: Map<number, Waiting>, heard: boolean}} Shared */

/** @type {Shared | undefined} */
let shared;
/** Whether no worker can be had: a bundler was not told of it, or a policy forbids it. */
let without = false;
let count = 0;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let ending;

/**
 * @param {AsideTask} task
 * @param {Transferable[]} [transfer] what nobody else holds
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
export async function aside(task, transfer = []) {
  const { startAside } = platform;
  if (!startAside || without) return here(task);
  clearTimeout(ending);
  shared ??= opened(startAside());
  const { worker, waiting, heard } = shared;
  const id = (count += 1);
  try {
    return await new Promise((resolve, reject) => {
      waiting.set(id, { task, resolve, reject });
      // As long as nobody knows whether it runs, the task may have to be done here.
      worker.postMessage({ id, task }, heard ? transfer : []);
    });
  } finally {
    waiting.delete(id);
    if (waiting.size === 0) ending = setTimeout(end, IDLE_MS);
  }
}

/** @param {AsideTask} task */
async function here(task) {
  return (await part(import('./aside-here.js'))).doHere(task);
}

/**
 * @param {Worker} worker
 * @returns {Shared}
 */
function opened(worker) {
  /** @type {Map<number, Waiting>} */
  const waiting = new Map();
  const made = { worker, waiting, heard: false };
  worker.addEventListener('message', ({ data: { id, type, bytes, error } }) => {
    // A worker of the user's own that serves sessions alone, and says so.
    if (type === 'failed') return leave();
    made.heard = true;
    if (bytes) waiting.get(id)?.resolve(bytes);
    else waiting.get(id)?.reject(new TraceCutError('poisoned', `the file cannot be made: ${error}`));
  });
  worker.addEventListener('error', (event) => {
    event.preventDefault?.();
    without ||= !made.heard;
    for (const { task, resolve, reject } of waiting.values()) {
      if (!made.heard) resolve(here(task));
      else reject(new TraceCutError('poisoned', `the worker that makes files was lost: ${event.message ?? ''}`));
    }
    if (shared === made) end();
  });
  function leave() {
    without = true;
    for (const { task, resolve } of waiting.values()) resolve(here(task));
    if (shared === made) end();
  }
  return made;
}

function end() {
  shared?.worker.terminate();
  shared = undefined;
}

/**
 * A PNG file of one channel.
 * @param {{pixels: Uint8Array<ArrayBuffer>, width: number, height: number, palette?: Uint8Array, alpha?: Uint8Array}} image
 *   `pixels` that nobody else holds
 */
export async function pngOf({ pixels, width, height, palette, alpha }) {
  /** @type {AsideTask} */
  const task = { kind: 'pixels', level: 6, pixels: { data: pixels, width, height, channels: 1 } };
  const data = await aside(task, [pixels.buffer]);
  return joined([pngHead({ width, height, palette, alpha }), data, pngTail()]);
}
