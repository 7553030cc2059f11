// Synthetic clips with known masks: `synthClip`.

import { checkOptions, checkWholeNumber } from '../check/errors.js';
import { platform } from '../platform.js';
import { type Instance, callInstance, release, startInstance } from '../worker/instance.js';
import type { WasmSource } from '../check/options.js';
import type { FlowField } from '../session/engine.js';
import type { Scene } from '../tracecut.js';

/** Options of `synthClip`. */
export interface ClipOptions {
  /** Width in pixels, 320 if not given. */
  width?: number;
  /** Height in pixels, 180 if not given. */
  height?: number;
  /** Number of frames, 30 if not given. */
  frames?: number;
  /** Seed of the textures; 0 if not given. */
  seed?: number;
  /** The wasm file, if it is not beside the package. */
  wasm?: WasmSource;
}

const LEGAL = ['width', 'height', 'frames', 'seed', 'wasm'];

/** Creates a synthetic clip of moving objects with known masks and flow, on the calling thread. */
export async function synthClip(options?: ClipOptions): Promise<Clip> {
  const { width = 320, height = 180, frames = 30, seed = 0, wasm } = checkOptions(options ?? {}, LEGAL);
  checkWholeNumber('param', 'width', width, 1, 4096);
  checkWholeNumber('param', 'height', height, 1, 4096);
  checkWholeNumber('param', 'frames', frames, 1, 10000);
  checkWholeNumber('param', 'seed', seed, 0, 4294967295);
  const owner = await startInstance(await platform.loadModule(wasm));
  return new Clip(owner, { width, height, frames, seed });
}

/** A synthetic clip with known masks and flow; created by `synthClip`. The same bytes everywhere. */
export class Clip {
  #owner;
  #scene: Scene | undefined;

  /** Width in pixels. */
  width: number;
  /** Height in pixels. */
  height: number;
  /** Number of frames. */
  numFrames: number;
  /** Number of objects, the background not counted. */
  numObjects: number;

  constructor(
    owner: Instance,
    { width, height, frames, seed }: { width: number; height: number; frames: number; seed: number },
  ) {
    this.#owner = owner;
    this.#scene = callInstance(owner, (glue) => new glue.Scene(width, height, frames, seed));
    this.width = width;
    this.height = height;
    this.numFrames = frames;
    this.numObjects = this.#call((scene) => scene.numObjects);
  }

  /** Returns frame `t`: opaque RGBA, can be pushed as it is. */
  frame(t: number): { data: Uint8ClampedArray<ArrayBuffer>; width: number; height: number } {
    this.#checkFrame(t);
    return this.#call((scene) => scene.frame(t));
  }

  /** Returns the object of each pixel of frame `t`; 0 is the background. */
  mask(t: number): Uint8Array<ArrayBuffer> {
    this.#checkFrame(t);
    return this.#call((scene) => scene.mask(t));
  }

  /** Returns the true motion from frame `t` to `t + 1`, in pixels. */
  flow(t: number): FlowField {
    this.#checkFrame(t);
    return this.#call((scene) => scene.flow(t));
  }

  /** Frees the clip's memory; closing twice is fine. A clip that is no longer referenced is garbage-collected. */
  close() {
    this.#scene = undefined;
    release(this.#owner, 'clip');
  }

  /** Same as `close`. */
  free() {
    this.close();
  }

  /** Closes the clip at the end of `using clip = await synthClip()`, in engines that have `using`. */
  [Symbol.dispose]() {
    this.close();
  }

  #checkFrame(t: number) {
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
  }

  #call<T>(call: (scene: Scene) => T) {
    return callInstance(this.#owner, () => call(this.#scene!));
  }
}
