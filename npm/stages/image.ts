// Boundary maps, superpixels and embedding discontinuities: their types, and the functions that compute them for a single
// image.

import { checkOptions, checkWholeNumber, isPlainObject } from '../check/errors.js';
import { type SessionOptions, splitOptions } from '../check/options.js';
import { type FrameSource, toRawFrame } from '../worker/frames.js';
import { createDecoderLoader, openEngine } from '../worker/remote.js';
import type { Engine, FlowField } from '../session/engine.js';

/**
 * Grid of a map's pixels. `width` × `height` is the working size, at which the image was processed; one of its pixels
 * covers `scaleX` × `scaleY` input pixels, so that its place `x` is `(x + 0.5) * scaleX - 0.5` in the input.
 */
export type Grid = {
  readonly width: number;
  readonly height: number;
  readonly scaleX: number;
  readonly scaleY: number;
};

/**
 * Probability for each pixel that it lies on a boundary between two objects, 0 to 1, row by row: `pb`, and `thin`, the
 * same on ridges one pixel wide and 0 elsewhere.
 */
export type BoundaryMap = Grid & { readonly pb: Float32Array<ArrayBuffer>; readonly thin: Float32Array<ArrayBuffer> };

/**
 * Discontinuities in the embedding of an image's pixels, 0 to 1, row by row: `discontinuity`, the root of the
 * discontinuities `d`; `pb`, the boundary probability from which the embedding is computed; `spectral`, the gradients of
 * its eigenvectors for comparison; and `combined`, the boundary probability from `pb` and `discontinuity`.
 */
export type ImageDiscontinuities = Grid & {
  readonly pb: Float32Array<ArrayBuffer>;
  readonly discontinuity: Float32Array<ArrayBuffer>;
  readonly spectral: Float32Array<ArrayBuffer>;
  readonly combined: Float32Array<ArrayBuffer>;
};

/**
 * Pairs of adjacent superpixels, `a < b`, with the length of their common border in pixels of the grid, and the mean of
 * `pb` along it.
 */
export type SuperpixelBorders = {
  readonly a: Uint32Array<ArrayBuffer>;
  readonly b: Uint32Array<ArrayBuffer>;
  readonly length: Float32Array<ArrayBuffer>;
  readonly pb: Float32Array<ArrayBuffer>;
};

/** Edges of the triangulation from which the superpixels are built, in pixels of the grid, with their {@link EdgeKind}. */
export type SuperpixelEdges = {
  readonly x0: Float32Array<ArrayBuffer>;
  readonly y0: Float32Array<ArrayBuffer>;
  readonly x1: Float32Array<ArrayBuffer>;
  readonly y1: Float32Array<ArrayBuffer>;
  readonly kind: Uint8Array<ArrayBuffer>;
};

/** A partition of an image: `label` holds the superpixel of each pixel, `0` to `count - 1`, row by row. */
export type Superpixels = Grid & {
  readonly count: number;
  readonly label: Uint32Array<ArrayBuffer>;
  readonly borders: SuperpixelBorders;
  readonly edges: SuperpixelEdges;
};

/** Kinds of edges of the triangulation; the values of `edges.kind`. */
export const EdgeKind = Object.freeze({
  /** Part of a contour. */
  Constraint: 0,
  /** Part of the image border. */
  Frame: 1,
  /** A Delaunay edge that closes a gap between contours. */
  Gabriel: 2,
  /** A Delaunay edge that separates nothing. */
  Deleted: 3,
});

/**
 * Options of a single image: two groups of the parameter tree, of which `boundaries` needs none, and `wasm`, `decoder`
 * and `worker` as for a session.
 */
export type ImageOptions = Pick<SessionOptions, 'contour' | 'superpixel' | 'wasm' | 'decoder' | 'worker'>;

/** Limits the number of superpixels. */
export interface SuperpixelCount {
  /** Most superpixels: they are joined across their weakest borders; an image with few contours has fewer. */
  count?: number;
}

/** Options of the superpixels of a single image. */
export type SuperpixelOptions = ImageOptions & SuperpixelCount;

/**
 * Options of the discontinuities of a single image: a group of the parameter tree, and `wasm`, `decoder` and `worker` as
 * for a session.
 */
export type DiscontinuityOptions = Pick<SessionOptions, 'still' | 'wasm' | 'decoder' | 'worker'>;

/** Options of an image engine: groups of the parameter tree, and `wasm`, `decoder` and `worker` as for a session. */
export type ImageEngineOptions = Pick<
  SessionOptions,
  'flow' | 'contour' | 'superpixel' | 'still' | 'wasm' | 'decoder' | 'worker'
>;

/** Options of the flow between two images. */
export type FlowOptions = Pick<SessionOptions, 'flow' | 'wasm' | 'decoder' | 'worker'>;

/** Most superpixels: as many as pixels of the largest image. */
const MAX_COUNT = 2 ** 26;

/**
 * Computes maps of single images, one after the other in one engine: the same as the functions of this package for one
 * image, without starting an engine for each. Close it when it is no longer needed.
 */
export class ImageEngine {
  #engine;
  #loadDecoder;

  constructor(engine: Engine, loadDecoder: () => Promise<WebAssembly.Module>) {
    this.#engine = engine;
    this.#loadDecoder = loadDecoder;
  }

  /** Returns the boundary probability of an image, at its own size. */
  async boundaries(image: FrameSource): Promise<BoundaryMap> {
    return toUnscaledGrid(await this.#engine.request('boundariesOf', await this.#copy(image)));
  }

  /**
   * Returns the Gabriel superpixels of an image, at its own size.
   * @param options most superpixels, 1 to 2^26
   */
  async superpixels(image: FrameSource, options: SuperpixelCount = {}): Promise<Superpixels> {
    const { count } = checkOptions(options, ['count']);
    if (count !== undefined) checkWholeNumber('param', 'count', count, 1, MAX_COUNT);
    return toUnscaledGrid(await this.#engine.request('superpixelsOf', await this.#copy(image), count));
  }

  /** Returns the boundaries of an image by the discontinuities of its pixel embedding. */
  async imageDiscontinuities(image: FrameSource): Promise<ImageDiscontinuities> {
    return this.#engine.request('discontinuitiesOf', await this.#copy(image));
  }

  /** Returns the optical flow from one image to another of the same size. */
  async flow(from: FrameSource, to: FrameSource): Promise<FlowField> {
    return this.#engine.request('flowOf', await this.#copy(from), await this.#copy(to));
  }

  /** Ends the engine; pending work rejects. */
  close() {
    this.#engine.close();
  }

  #copy(image: FrameSource) {
    return toRawFrame(image, this.#loadDecoder);
  }
}

/** Opens an engine for boundaries, superpixels, discontinuities and flow of many single images, which starts only once. */
export function createImageEngine(options?: ImageEngineOptions): Promise<ImageEngine> {
  return openImageEngine(options, ['flow', 'contour', 'superpixel', 'still']);
}

async function openImageEngine(options: ImageEngineOptions | undefined, groups: string[], others: string[] = []) {
  const split = splitOptions(options, { others, groups, settings: ['wasm', 'decoder', 'worker'] });
  const engine = await openEngine({ ...split, threads: 1 });
  return new ImageEngine(engine, createDecoderLoader(split.decoder));
}

/** Returns the boundary probability of a single image, at its own size. */
export function boundaries(image: FrameSource, options?: ImageOptions): Promise<BoundaryMap> {
  return requestOnce(options, ['contour', 'superpixel'], (engine) => engine.boundaries(image));
}

/** Returns the Gabriel superpixels of a single image, at its own size. */
export async function superpixels(image: FrameSource, options?: SuperpixelOptions): Promise<Superpixels> {
  const { count, ...engineOptions } = isPlainObject(options) ? options : { count: undefined };
  const checkedOptions = isPlainObject(options) ? engineOptions : options;
  const superpixelsOf = (engine: ImageEngine) => engine.superpixels(image, { count });
  return requestOnce(checkedOptions, ['contour', 'superpixel'], superpixelsOf, ['count']);
}

/**
 * Returns the boundaries of a single image by the discontinuities of its pixel embedding, at its own size or reduced to
 * `still.maxSide`.
 */
export function imageDiscontinuities(
  image: FrameSource,
  options?: DiscontinuityOptions,
): Promise<ImageDiscontinuities> {
  return requestOnce(options, ['still'], (engine) => engine.imageDiscontinuities(image));
}

/** Returns the optical flow from one image to another of the same size, at that size. */
export function flow(from: FrameSource, to: FrameSource, options?: FlowOptions): Promise<FlowField> {
  return requestOnce(options, ['flow'], (engine) => engine.flow(from, to));
}

/** Opens an engine for one request. */
async function requestOnce<T>(
  options: ImageEngineOptions | undefined,
  groups: string[],
  request: (engine: ImageEngine) => Promise<T>,
  others: string[] = [],
): Promise<T> {
  const engine = await openImageEngine(options, groups, others);
  try {
    return await request(engine);
  } finally {
    engine.close();
  }
}

const toUnscaledGrid = <T extends { width: number; height: number }>(map: T) => addScale(map, map.width, map.height);

/** Adds the scale of a map's grid relative to an input of `width` × `height` pixels. */
export function addScale<T extends { width: number; height: number }>(map: T, width: number, height: number): T & Grid {
  return { ...map, scaleX: width / map.width, scaleY: height / map.height };
}
