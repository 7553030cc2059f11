// Boundary maps, superpixels and embedding discontinuities: their types, and the functions that make them of a single
// image.

import { illegal } from './errors.js';
import { toRawFrame } from './frames.js';
import { isPlainObject, splitOptions, wholeNumber } from './options.js';
import { once, openEngine } from './platform.js';

/**
 * The grid that a map's pixels lie on. `width` × `height` is the size that the image was processed at; one of its
 * pixels covers `scaleX` × `scaleY` input pixels, so that its place `x` is `(x + 0.5) * scaleX - 0.5` in the input.
 * @typedef {{readonly width: number, readonly height: number, readonly scaleX: number, readonly scaleY: number}} Grid
 */

/**
 * How likely each pixel lies on a boundary between two things, 0 to 1, row by row: `pb`, and `thin`, the same on ridges
 * one pixel wide and 0 elsewhere.
 * @typedef {Grid & {readonly pb: Float32Array<ArrayBuffer>, readonly thin: Float32Array<ArrayBuffer>}} BoundaryMap
 */

/**
 * Where the embedding of an image's pixels changes, 0 to 1, row by row: `discontinuity`, the root of the
 * discontinuities `d`; beside it `pb`, the boundary probability that the embedding comes from, `spectral`, the
 * gradients of its eigenvectors to compare with, and `combined`, the boundary probability by `pb` and `discontinuity`
 * together.
 * @typedef {Grid & {readonly pb: Float32Array<ArrayBuffer>, readonly discontinuity: Float32Array<ArrayBuffer>,
 *   readonly spectral:
 *   Float32Array<ArrayBuffer>, readonly combined: Float32Array<ArrayBuffer>}} ImageDiscontinuities
 */

/**
 * Which superpixels touch: `a < b`, the length of their common border in pixels of the grid, and the mean of `pb` along
 * it.
 * @typedef {{readonly a: Uint32Array<ArrayBuffer>, readonly b: Uint32Array<ArrayBuffer>, readonly length:
 *   Float32Array<ArrayBuffer>,
 *   readonly pb: Float32Array<ArrayBuffer>}} SuperpixelBorders
 */

/**
 * The edges of the triangulation that the superpixels come from, in pixels of the grid, with their {@link EdgeKind}.
 * @typedef {{readonly x0: Float32Array<ArrayBuffer>, readonly y0: Float32Array<ArrayBuffer>, readonly x1:
 *   Float32Array<ArrayBuffer>,
 *   readonly y1: Float32Array<ArrayBuffer>, readonly kind: Uint8Array<ArrayBuffer>}} SuperpixelEdges
 */

/**
 * A partition of an image: `label` holds the superpixel of each pixel, `0` to `count - 1`, row by row.
 * @typedef {Grid & {readonly count: number, readonly label: Uint32Array<ArrayBuffer>, readonly borders:
 *   SuperpixelBorders, readonly edges:
 *   SuperpixelEdges}} Superpixels
 */

/** What an edge of the triangulation became; the values of `edges.kind`. */
export const EdgeKind = Object.freeze({
  /** A piece of a contour. */
  Constraint: 0,
  /** A piece of the image's frame. */
  Frame: 1,
  /** A Delaunay edge that closes a gap between contours. */
  Gabriel: 2,
  /** A Delaunay edge that separates nothing. */
  Deleted: 3,
});

/**
 * Options of a single image: two groups of the parameter tree, of which `boundaries` needs none, and `wasm`, `decoder`
 * and `worker` as for a session.
 * @typedef {Pick<import('./options.js').SessionOptions, 'contour' | 'superpixel' | 'wasm' | 'decoder' | 'worker'>}
 *   ImageOptions
 */

/**
 * How many superpixels are wanted.
 * @typedef {object} SuperpixelCount
 * @property {number} [count] they are joined across their weakest borders until so many are left; an image with few
 *   contours has fewer
 */

/**
 * Options of the superpixels of a single image.
 * @typedef {ImageOptions & SuperpixelCount} SuperpixelOptions
 */

/**
 * Options of the discontinuities of a single image: a group of the parameter tree, and `wasm`, `decoder` and `worker` as
 * for a session.
 * @typedef {Pick<import('./options.js').SessionOptions, 'still' | 'wasm' | 'decoder' | 'worker'>} DiscontinuityOptions
 */

/**
 * Options of an image engine: groups of the parameter tree, and `wasm`, `decoder` and `worker` as for a session.
 * @typedef {Pick<import('./options.js').SessionOptions, 'flow' | 'contour' | 'superpixel' | 'still' | 'wasm' | 'decoder'
 *   | 'worker'>} ImageEngineOptions
 */

/**
 * Options of the flow between two images.
 * @typedef {Pick<import('./options.js').SessionOptions, 'flow' | 'wasm' | 'decoder' | 'worker'>} FlowOptions
 */

const ALWAYS = ['wasm', 'decoder', 'worker'];
const MAX_COUNT = 2 ** 26;

/**
 * Maps of single images, one after the other in one engine: what a function of this package does with one image, without
 * starting anew for each. Close it when it is no longer needed.
 */
export class ImageEngine {
  #engine;
  #loadDecoder;

  /**
   * @param {import('./engine.js').Engine} engine
   * @param {() => Promise<WebAssembly.Module>} loadDecoder
   */
  constructor(engine, loadDecoder) {
    this.#engine = engine;
    this.#loadDecoder = loadDecoder;
  }

  /**
   * The boundary probability of an image, at its own size.
   * @param {import('./frames.js').FrameSource} image
   * @returns {Promise<BoundaryMap>}
   */
  async boundaries(image) {
    return unscaled(await this.#engine.request('boundariesOf', await this.#raw(image)));
  }

  /**
   * The Gabriel superpixels of an image, at its own size.
   * @param {import('./frames.js').FrameSource} image
   * @param {{count?: number}} [options] most superpixels, 1 to 2^26
   * @returns {Promise<Superpixels>}
   */
  async superpixels(image, { count } = {}) {
    if (count !== undefined) wholeNumber('param', 'count', count, 1, MAX_COUNT);
    return unscaled(await this.#engine.request('superpixelsOf', await this.#raw(image), count));
  }

  /**
   * Boundaries of an image by the discontinuities of its pixel embedding.
   * @param {import('./frames.js').FrameSource} image
   * @returns {Promise<ImageDiscontinuities>}
   */
  async imageDiscontinuities(image) {
    return this.#engine.request('discontinuitiesOf', await this.#raw(image));
  }

  /**
   * The optical flow from one image to another of the same size.
   * @param {import('./frames.js').FrameSource} from
   * @param {import('./frames.js').FrameSource} to
   * @returns {Promise<import('./engine.js').FlowField>}
   */
  async flow(from, to) {
    return this.#engine.request('flowOf', await this.#raw(from), await this.#raw(to));
  }

  /** Ends the engine; what it still works on is rejected. */
  close() {
    this.#engine.close();
  }

  /** @param {import('./frames.js').FrameSource} image */
  #raw(image) {
    return toRawFrame(image, this.#loadDecoder);
  }
}

/**
 * @param {ImageEngineOptions | undefined} options
 * @param {import('./platform.js').Platform} platform
 * @param {string[]} [groups] of parameters that are legal
 * @returns {Promise<ImageEngine>}
 */
export async function openImageEngine(options, platform, groups = ['flow', 'contour', 'superpixel', 'still']) {
  const split = splitOptions(checked(options, [...groups, ...ALWAYS]));
  const engine = await openEngine({ ...split, threads: 1 }, platform);
  return new ImageEngine(
    engine,
    once(() => platform.loadDecoder(split.decoder)),
  );
}

/**
 * @param {import('./frames.js').FrameSource} image
 * @param {ImageOptions | undefined} options
 * @param {import('./platform.js').Platform} platform
 * @returns {Promise<BoundaryMap>}
 */
export function boundariesOf(image, options, platform) {
  return askOnce(options, platform, ['contour', 'superpixel'], (engine) => engine.boundaries(image));
}

/**
 * @param {import('./frames.js').FrameSource} image
 * @param {SuperpixelOptions | undefined} options
 * @param {import('./platform.js').Platform} platform
 * @returns {Promise<Superpixels>}
 */
export async function superpixelsOf(image, options, platform) {
  const { count, ...others } = isPlainObject(options)
    ? /** @type {SuperpixelOptions} */ (options)
    : { count: undefined };
  const rest = isPlainObject(options) ? others : options;
  return askOnce(rest, platform, ['contour', 'superpixel'], (engine) => engine.superpixels(image, { count }));
}

/**
 * @param {import('./frames.js').FrameSource} image
 * @param {DiscontinuityOptions | undefined} options
 * @param {import('./platform.js').Platform} platform
 * @returns {Promise<ImageDiscontinuities>}
 */
export function discontinuitiesOf(image, options, platform) {
  return askOnce(options, platform, ['still'], (engine) => engine.imageDiscontinuities(image));
}

/**
 * @param {import('./frames.js').FrameSource} from
 * @param {import('./frames.js').FrameSource} to
 * @param {FlowOptions | undefined} options
 * @param {import('./platform.js').Platform} platform
 * @returns {Promise<import('./engine.js').FlowField>}
 */
export function flowOf(from, to, options, platform) {
  return askOnce(options, platform, ['flow'], (engine) => engine.flow(from, to));
}

/**
 * Asks an engine one thing.
 * @template T
 * @param {ImageEngineOptions | undefined} options
 * @param {import('./platform.js').Platform} platform
 * @param {string[]} groups
 * @param {(engine: ImageEngine) => Promise<T>} question
 * @returns {Promise<T>}
 */
async function askOnce(options, platform, groups, question) {
  const engine = await openImageEngine(options, platform, groups);
  try {
    return await question(engine);
  } finally {
    engine.close();
  }
}

/**
 * @param {ImageEngineOptions | undefined} options
 * @param {string[]} legal
 */
function checked(options, legal) {
  const stray = isPlainObject(options) && Object.keys(options).find((key) => !legal.includes(key));
  if (stray) throw illegal('param', stray, /** @type {Record<string, unknown>} */ (options)[stray], legal.join(', '));
  return options;
}

/**
 * @template {{width: number, height: number}} T
 * @param {T} map
 */
const unscaled = (map) => onGrid(map, map.width, map.height);

/**
 * The map with its grid's scale against an input of `width` × `height` pixels.
 * @template {{width: number, height: number}} T
 * @param {T} map
 * @param {number} width
 * @param {number} height
 * @returns {T & Grid}
 */
export function onGrid(map, width, height) {
  return { ...map, scaleX: width / map.width, scaleY: height / map.height };
}
