// Made clips with known masks: `synthClip`.

import { illegal, isPlainObject, wholeNumber } from '../check/errors.js';
import { platform } from '../platform.js';
import { end, guarded, instance } from '../worker/instance.js';

/**
 * @typedef {object} ClipOptions
 * @property {number} [width] in pixels, 320 if not given
 * @property {number} [height] in pixels, 180 if not given
 * @property {number} [frames] 30 if not given
 * @property {number} [seed] another one gives other textures; 0 if not given
 * @property {import('../check/options.js').WasmSource} [wasm] where the wasm file is, when not beside the package
 */

/**
 * Makes a clip of moving objects with known masks and known flow, on the calling thread.
 * @param {ClipOptions} [options]
 * @returns {Promise<Clip>}
 */
export async function synthClip(options) {
  const given = options ?? {};
  if (!isPlainObject(given))
    throw illegal('param', 'options', options, 'an object such as {width: 320, height: 180, frames: 30}');
  const { width = 320, height = 180, frames = 30, seed = 0, wasm, ...others } = /** @type {ClipOptions} */ (given);
  const unknown = Object.keys(others)[0];
  if (unknown)
    throw illegal(
      'param',
      unknown,
      /** @type {Record<string, unknown>} */ (others)[unknown],
      'width, height, frames or seed',
    );
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
  /** @type {import('../tracecut.js').Scene | undefined} */
  #scene;

  /**
   * @param {import('../worker/instance.js').Instance} owner
   * @param {{width: number, height: number, frames: number, seed: number}} options
   */
  constructor(owner, { width, height, frames, seed }) {
    this.#owner = owner;
    this.#scene = guarded(owner, (glue) => new glue.Scene(width, height, frames, seed));
    /** Width in pixels. */
    this.width = width;
    /** Height in pixels. */
    this.height = height;
    /** Number of frames. */
    this.numFrames = frames;
    /** Number of objects, the background not counted. */
    this.numObjects = this.#call((scene) => scene.numObjects);
  }

  /**
   * Frame `t`: RGBA, opaque; can be pushed as it is.
   * @param {number} t
   * @returns {{data: Uint8ClampedArray<ArrayBuffer>, width: number, height: number}}
   */
  frame(t) {
    this.#checkFrame(t);
    return this.#call((scene) => scene.frame(t));
  }

  /**
   * The object that each pixel of frame `t` belongs to; 0 is the background.
   * @param {number} t
   * @returns {Uint8Array<ArrayBuffer>}
   */
  mask(t) {
    this.#checkFrame(t);
    return this.#call((scene) => scene.mask(t));
  }

  /**
   * The true motion from frame `t` to `t + 1`, in pixels.
   * @param {number} t
   * @returns {import('../session/engine.js').FlowField}
   */
  flow(t) {
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

  /** @param {number} t */
  #checkFrame(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
  }

  /**
   * @template T
   * @param {(scene: import('../tracecut.js').Scene) => T} call
   */
  #call(call) {
    return guarded(this.#owner, () => call(/** @type {import('../tracecut.js').Scene} */ (this.#scene)));
  }
}
