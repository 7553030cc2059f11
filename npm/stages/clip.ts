// Made clips with known masks: `synthClip`.

import { illegal, isPlainObject, wholeNumber } from '../check/errors.js';
import { platform } from '../platform.js';
import { type Instance, end, guarded, instance } from '../worker/instance.js';
import type { WasmSource } from '../check/options.js';
import type { FlowField } from '../session/engine.js';
import type { Scene } from '../tracecut.js';

export interface ClipOptions {
  /** In pixels, 320 if not given. */
  width?: number;
  /** In pixels, 180 if not given. */
  height?: number;
  /** 30 if not given. */
  frames?: number;
  /** Another one gives other textures; 0 if not given. */
  seed?: number;
  /** Where the wasm file is, when not beside the package. */
  wasm?: WasmSource;
}

/** Makes a clip of moving objects with known masks and known flow, on the calling thread. */
export async function synthClip(options?: ClipOptions): Promise<Clip> {
  const given = options ?? {};
  if (!isPlainObject(given))
    throw illegal('param', 'options', options, 'an object such as {width: 320, height: 180, frames: 30}');
  const { width = 320, height = 180, frames = 30, seed = 0, wasm, ...others } = given;
  const unknown = Object.keys(others)[0];
  if (unknown) throw illegal('param', unknown, others[unknown], 'width, height, frames or seed');
  wholeNumber('param', 'width', width, 1, 4096);
  wholeNumber('param', 'height', height, 1, 4096);
  wholeNumber('param', 'frames', frames, 1, 10000);
  wholeNumber('param', 'seed', seed, 0, 4294967295);
  const owner = await instance(await platform.loadModule(wasm));
  return new Clip(owner, { width, height, frames, seed });
}

/** A clip made by rule, with known masks and known flow; made by `synthClip`. The same bytes everywhere. */
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
    this.#scene = guarded(owner, (glue) => new glue.Scene(width, height, frames, seed));
    this.width = width;
    this.height = height;
    this.numFrames = frames;
    this.numObjects = this.#call((scene) => scene.numObjects);
  }

  /** Frame `t`: RGBA, opaque; can be pushed as it is. */
  frame(t: number): { data: Uint8ClampedArray<ArrayBuffer>; width: number; height: number } {
    this.#checkFrame(t);
    return this.#call((scene) => scene.frame(t));
  }

  /** The object that each pixel of frame `t` belongs to; 0 is the background. */
  mask(t: number): Uint8Array<ArrayBuffer> {
    this.#checkFrame(t);
    return this.#call((scene) => scene.mask(t));
  }

  /** The true motion from frame `t` to `t + 1`, in pixels. */
  flow(t: number): FlowField {
    this.#checkFrame(t);
    return this.#call((scene) => scene.flow(t));
  }

  /** Frees the clip's memory; closing twice is fine. A clip that is forgotten is freed with the other garbage. */
  close() {
    this.#scene = undefined;
    end(this.#owner, 'clip');
  }

  /** As `close`. */
  free() {
    this.close();
  }

  /** `using clip = await synthClip()` closes it (an engine without `Symbol.dispose` has no `using` either). */
  [Symbol.dispose]() {
    this.close();
  }

  #checkFrame(t: number) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
  }

  #call<T>(call: (scene: Scene) => T) {
    return guarded(this.#owner, () => call(this.#scene!));
  }
}
