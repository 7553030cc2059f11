// Boundary maps, superpixels and embedding discontinuities: their types, and the functions that make them of a single
// image.

import { illegal, isPlainObject, wholeNumber } from '../check/errors.js';
import { splitOptions } from '../check/options.js';
import { toRawFrame } from '../worker/frames.js';
import { decoderLoader, openEngine } from '../worker/remote.js';

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
 * @typedef {Pick<import('../check/options.js').SessionOptions, 'contour' | 'superpixel' | 'wasm' | 'decoder' | 'worker'>}
 *   ImageOptions
 */

/**
 * How many superpixels are wanted.
 * @typedef {object} SuperpixelCount
 * @property {number} [count] they are joined across their weakest borders until this many are left; an image with few
 *   contours has fewer
 */

/**
 * Options of the superpixels of a single image.
 * @typedef {ImageOptions & SuperpixelCount} SuperpixelOptions
 */

/**
 * Options of the discontinuities of a single image: a group of the parameter tree, and `wasm`, `decoder` and `worker` as
 * for a session.
 * @typedef {Pick<import('../check/options.js').SessionOptions, 'still' | 'wasm' | 'decoder' | 'worker'>} DiscontinuityOptions
 */

/**
 * Options of an image engine: groups of the parameter tree, and `wasm`, `decoder` and `worker` as for a session.
 * @typedef {Pick<import('../check/options.js').SessionOptions, 'flow' | 'contour' | 'superpixel' | 'still' | 'wasm' | 'decoder'
 *   | 'worker'>} ImageEngineOptions
 */

/**
 * Options of the flow between two images.
 * @typedef {Pick<import('../check/options.js').SessionOptions, 'flow' | 'wasm' | 'decoder' | 'worker'>} FlowOptions
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
   * @param {import('../session/engine.js').Engine} engine
   * @param {() => Promise<WebAssembly.Module>} loadDecoder
   */
  constructor(engine, loadDecoder) {
    this.#engine = engine;
    this.#loadDecoder = loadDecoder;
  }

  /**
   * The boundary probability of an image, at its own size.
   * @param {import('../worker/frames.js').FrameSource} image
   * @returns {Promise<BoundaryMap>}
   */
  async boundaries(image) {
    return unscaled(await this.#engine.request('boundariesOf', await this.#raw(image)));
  }

  /**
   * The Gabriel superpixels of an image, at its own size.
   * @param {import('../worker/frames.js').FrameSource} image
   * @param {{count?: number}} [options] most superpixels, 1 to 2^26
   * @returns {Promise<Superpixels>}
   */
  async superpixels(image, { count } = {}) {
    if (count !== undefined) wholeNumber('param', 'count', count, 1, MAX_COUNT);
    return unscaled(await this.#engine.request('superpixelsOf', await this.#raw(image), count));
  }

  /**
   * Boundaries of an image by the discontinuities of its pixel embedding.
   * @param {import('../worker/frames.js').FrameSource} image
   * @returns {Promise<ImageDiscontinuities>}
   */
  async imageDiscontinuities(image) {
    return this.#engine.request('discontinuitiesOf', await this.#raw(image));
  }

  /**
   * The optical flow from one image to another of the same size.
   * @param {import('../worker/frames.js').FrameSource} from
   * @param {import('../worker/frames.js').FrameSource} to
   * @returns {Promise<import('../session/engine.js').FlowField>}
   */
  async flow(from, to) {
    return this.#engine.request('flowOf', await this.#raw(from), await this.#raw(to));
  }

  /** Ends the engine; what it still works on is rejected. */
  close() {
    this.#engine.close();
  }

  /** @param {import('../worker/frames.js').FrameSource} image */
  #raw(image) {
    return toRawFrame(image, this.#loadDecoder);
  }
}

/**
 * Opens an engine for boundaries, superpixels, discontinuities and flow of many single images: all that starting costs is
 * paid once.
 * @param {ImageEngineOptions} [options]
 * @returns {Promise<ImageEngine>}
 */
export function createImageEngine(options) {
  return opened(options, ['flow', 'contour', 'superpixel', 'still']);
}

/**
 * @param {ImageEngineOptions | undefined} options
 * @param {string[]} groups of parameters that are legal
 */
async function opened(options, groups) {
  const split = splitOptions(checked(options, [...groups, ...ALWAYS]));
  const engine = await openEngine({ ...split, threads: 1 });
  return new ImageEngine(engine, decoderLoader(split.decoder));
}

/**
 * The boundary probability of a single image, at its own size.
 * @param {import('../worker/frames.js').FrameSource} image
 * @param {ImageOptions} [options]
 * @returns {Promise<BoundaryMap>}
 */
export function boundaries(image, options) {
  return askOnce(options, ['contour', 'superpixel'], (engine) => engine.boundaries(image));
}

/**
 * The Gabriel superpixels of a single image, at its own size.
 * @param {import('../worker/frames.js').FrameSource} image
 * @param {SuperpixelOptions} [options]
 * @returns {Promise<Superpixels>}
 */
export async function superpixels(image, options) {
  const { count, ...others } = isPlainObject(options)
    ? /** @type {SuperpixelOptions} */ (options)
    : { count: undefined };
  const rest = isPlainObject(options) ? others : options;
  return askOnce(rest, ['contour', 'superpixel'], (engine) => engine.superpixels(image, { count }));
}

/**
 * Boundaries of a single image by the discontinuities of its pixel embedding, at its own size or reduced to
 * `still.maxSide`.
 * @param {import('../worker/frames.js').FrameSource} image
 * @param {DiscontinuityOptions} [options]
 * @returns {Promise<ImageDiscontinuities>}
 */
export function imageDiscontinuities(image, options) {
  return askOnce(options, ['still'], (engine) => engine.imageDiscontinuities(image));
}

/**
 * The optical flow from one image to another of the same size, at that size: where each pixel goes.
 * @param {import('../worker/frames.js').FrameSource} from
 * @param {import('../worker/frames.js').FrameSource} to
 * @param {FlowOptions} [options]
 * @returns {Promise<import('../session/engine.js').FlowField>}
 */
export function flow(from, to, options) {
  return askOnce(options, ['flow'], (engine) => engine.flow(from, to));
}

/**
 * Asks an engine one thing.
 * @template T
 * @param {ImageEngineOptions | undefined} options
 * @param {string[]} groups
 * @param {(engine: ImageEngine) => Promise<T>} question
 * @returns {Promise<T>}
 */
async function askOnce(options, groups, question) {
  const engine = await opened(options, groups);
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
