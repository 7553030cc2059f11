// Instances of the wasm module, each with its own memory: a failure in one does not affect the others, and a memory, which
// cannot shrink, is freed with its session. The decoder's module has one for all: it reads PNG and JPEG files and enlarges masks.

import { type ErrorCode, TraceCutError, throwIfRust } from '../check/errors.js';
import startDecoder, { __wbg_reset_state, decode, enlarge } from '../decoder.js';
import { makeGlue } from '../glue.js';
import { type RawFrame, fromImage } from './frames.js';

export type Glue = typeof import('../tracecut.js');
export type Instance = {
  glue: Glue | undefined;
  memory: WebAssembly.Memory | undefined;
  error: TraceCutError | undefined;
};

/** Starts a new instance. */
export async function startInstance(module: WebAssembly.Module): Promise<Instance> {
  const glue = makeGlue();
  try {
    const { memory } = await glue.default({ module_or_path: module });
    return { glue, memory, error: undefined };
  } catch (error) {
    throw isOutOfMemory(error) ? createMemoryError(0, error) : error;
  }
}

/**
 * Calls into an instance. An error that Rust returned has a code. Anything else is a panic or a trap, after which the
 * instance cannot be trusted: it ends, with all its objects.
 */
export function callInstance<T>(owner: Instance, call: (glue: Glue) => T): T {
  const { glue, memory } = owner;
  if (!glue) throw owner.error;
  try {
    return call(glue);
  } catch (error) {
    throwIfRust(error);
    // V8's stack keeps the instance alive until it is formatted.
    if (error instanceof Error) void error.stack;
    const panic = readPanic(glue);
    const bytes = memory?.buffer.byteLength ?? 0;
    owner.error =
      isOutOfMemory(error) || (panic ? /capacity overflow/.test(panic) : isUnreachable(error) && isFull(memory))
        ? createMemoryError(bytes, error)
        : new TraceCutError(
            'poisoned',
            `the engine stopped on an internal error: ${panic ?? error}. Create a new session.`,
            { cause: error },
          );
    owner.glue = owner.memory = undefined;
    throw owner.error;
  }
}

/**
 * Releases an instance: its memory is freed when nothing else refers to its objects. Later calls fail, as its owner is
 * closed.
 */
export function release(owner: Instance, name: string) {
  owner.glue = owner.memory = undefined;
  owner.error ??= new TraceCutError('closed', `the ${name} is closed; create a new one`);
}

/** Returns the message of a panic: other exports still run after one. */
function readPanic(glue: Glue) {
  try {
    return glue.panicMessage();
  } catch {
    return undefined;
  }
}

/** Returns true if the JavaScript engine had no memory for an array or an instance; a full stack is a `RangeError` too. */
function isOutOfMemory(error: unknown) {
  return error instanceof RangeError && !/stack/i.test(error.message);
}

/** Returns true for Rust's trap without memory, which has no panic. (A size that no memory could hold is a panic.) */
function isUnreachable(error: unknown) {
  return error instanceof WebAssembly.RuntimeError && /unreachable/i.test(error.message);
}

/** Returns true if a memory cannot grow by a GiB, or double: growing lists request as much, less if they are small. */
function isFull(memory: WebAssembly.Memory | undefined) {
  try {
    memory?.grow(Math.max(memory.buffer.byteLength, 2 ** 30) / 65536);
    return false;
  } catch {
    return true;
  }
}

function createMemoryError(bytes: number, cause: unknown) {
  const mebibytes = Math.ceil(bytes / 2 ** 20);
  return new TraceCutError(
    'memory',
    `the engine ran out of memory at ${mebibytes} MiB. Create a new session with fewer frames or a smaller clip.maxSide.`,
    { cause },
  );
}

let starting: Promise<unknown> | undefined;

export type Pixels = { data: Uint8Array<ArrayBuffer>; width: number; height: number };

/** Decodes the pixels of a frame. */
export async function toPixels(frame: RawFrame): Promise<Pixels> {
  if (frame.kind === 'pixels') return frame;
  if (!frame.decoder) throw new TraceCutError('state', 'a file came without the module that decodes it');
  const call = () => decode(frame.data, frame.maxPixels);
  const [data, width, height] = await callDecoder(frame.decoder, call, 'image cannot be decoded', 'decode');
  return { data, width, height };
}

/**
 * Calls into the module after it has started. An error that Rust returned has a code; anything else is a panic or a trap.
 * @param failure description of a failed call
 * @param code of its error
 */
export async function callDecoder<T>(
  module: WebAssembly.Module,
  call: () => T,
  failure: string,
  code: ErrorCode = 'poisoned',
): Promise<T> {
  starting ??= startDecoder({ module_or_path: module });
  await starting;
  try {
    return call();
  } catch (error) {
    throwIfRust(error);
    // The next call gets a fresh instance.
    __wbg_reset_state();
    throw new TraceCutError(code, `${failure}: the decoder stopped on an internal error: ${error}`, { cause: error });
  }
}

/**
 * A mask at the size of its picture: `labels` holds the label of each pixel, `alpha` the opacity of the selected objects
 * there, 0 to 255: at least 128 exactly where the label is selected, soft where the picture has a soft edge, and 0 or 255
 * away from their borders.
 */
export type EnlargedMask = {
  readonly width: number;
  readonly height: number;
  readonly labels: Uint8Array<ArrayBuffer>;
  readonly alpha: Uint8Array<ArrayBuffer>;
};

/** A picture that a worker reads, as reading it would be noticed in the page's thread. */
export type HeldImage = { kind: 'image'; image: VideoFrame | ImageBitmap };

/** A mask and its picture, in memory that nothing else uses. */
export type EnlargeTask = {
  labels: Uint8Array<ArrayBuffer>;
  width: number;
  picture: RawFrame | HeldImage;
  chosen: Uint8Array<ArrayBuffer>;
  /** True to return the picture's pixels too. */
  readsPicture?: boolean;
  module: WebAssembly.Module;
};

/** A mask, and the RGBA pixels of its picture if requested. */
export type EnlargedFrame = EnlargedMask & { picture?: Uint8Array<ArrayBuffer> };

/** Enlarges a mask in this thread. */
export async function enlargeInThread(task: EnlargeTask): Promise<EnlargedFrame> {
  const { labels, width, chosen, module } = task;
  const pixels = await readPixels(task.picture);
  const call = () => enlarge(labels, width, pixels.data, pixels.width, pixels.height, chosen);
  const [large, alpha] = await callDecoder(module, call, 'the mask cannot be enlarged');
  const picture = task.readsPicture ? { picture: pixels.data } : {};
  return { width: pixels.width, height: pixels.height, labels: large, alpha, ...picture };
}

async function readPixels(picture: EnlargeTask['picture']) {
  if (picture.kind !== 'image') return toPixels(picture);
  try {
    return await toPixels(await fromImage(picture.image));
  } finally {
    picture.image.close();
  }
}
