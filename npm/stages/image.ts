// Boundary maps, superpixels and embedding discontinuities: their types, and the functions that make them of a single
// image.

import { illegal, isPlainObject, wholeNumber } from '../check/errors.js';
import { type SessionOptions, splitOptions } from '../check/options.js';
import { type FrameSource, toRawFrame } from '../worker/frames.js';
import { decoderLoader, openEngine } from '../worker/remote.js';
import type { Engine, FlowField } from '../session/engine.js';

/**
 * The grid that a map's pixels lie on. `width` × `height` is the size that the image was processed at; one of its
 * pixels covers `scaleX` × `scaleY` input pixels, so that its place `x` is `(x + 0.5) * scaleX - 0.5` in the input.
 */
export type Grid = {
  readonly width: number;
  readonly height: number;
  readonly scaleX: number;
  readonly scaleY: number;
};

/**
 * How likely each pixel lies on a boundary between two things, 0 to 1, row by row: `pb`, and `thin`, the same on ridges
 * one pixel wide and 0 elsewhere.
 */
export type BoundaryMap = Grid & { readonly pb: Float32Array<ArrayBuffer>; readonly thin: Float32Array<ArrayBuffer> };

/**
 * Where the embedding of an image's pixels changes, 0 to 1, row by row: `discontinuity`, the root of the
 * discontinuities `d`; beside it `pb`, the boundary probability that the embedding comes from, `spectral`, the
 * gradients of its eigenvectors to compare with, and `combined`, the boundary probability by `pb` and `discontinuity`
 * together.
 */
export type ImageDiscontinuities = Grid & {
  readonly pb: Float32Array<ArrayBuffer>;
  readonly discontinuity: Float32Array<ArrayBuffer>;
  readonly spectral: Float32Array<ArrayBuffer>;
  readonly combined: Float32Array<ArrayBuffer>;
};

/**
 * Which superpixels touch: `a < b`, the length of their common border in pixels of the grid, and the mean of `pb` along
 * it.
 */
export type SuperpixelBorders = {
  readonly a: Uint32Array<ArrayBuffer>;
  readonly b: Uint32Array<ArrayBuffer>;
  readonly length: Float32Array<ArrayBuffer>;
  readonly pb: Float32Array<ArrayBuffer>;
};

/**
 * The edges of the triangulation that the superpixels come from, in pixels of the grid, with their {@link EdgeKind}.
 */
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
 */
export type ImageOptions = Pick<SessionOptions, 'contour' | 'superpixel' | 'wasm' | 'decoder' | 'worker'>;

/** How many superpixels are wanted. */
export interface SuperpixelCount {
  /** They are joined across their weakest borders until this many are left; an image with few contours has fewer. */
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

const ALWAYS = ['wasm', 'decoder', 'worker'];
const MAX_COUNT = 2 ** 26;

/**
 * Maps of single images, one after the other in one engine: what a function of this package does with one image, without
 * starting anew for each. Close it when it is no longer needed.
 */
export class ImageEngine {
  #engine;
  #loadDecoder;

  constructor(engine: Engine, loadDecoder: () => Promise<WebAssembly.Module>) {
    this.#engine = engine;
    this.#loadDecoder = loadDecoder;
  }

  /** The boundary probability of an image, at its own size. */
  async boundaries(image: FrameSource): Promise<BoundaryMap> {
    return unscaled(await this.#engine.request('boundariesOf', await this.#raw(image)));
  }

  /**
   * The Gabriel superpixels of an image, at its own size.
   * @param options most superpixels, 1 to 2^26
   */
  async superpixels(image: FrameSource, { count }: { count?: number } = {}): Promise<Superpixels> {
    if (count !== undefined) wholeNumber('param', 'count', count, 1, MAX_COUNT);
    return unscaled(await this.#engine.request('superpixelsOf', await this.#raw(image), count));
  }

  /** Boundaries of an image by the discontinuities of its pixel embedding. */
  async imageDiscontinuities(image: FrameSource): Promise<ImageDiscontinuities> {
    return this.#engine.request('discontinuitiesOf', await this.#raw(image));
  }

  /** The optical flow from one image to another of the same size. */
  async flow(from: FrameSource, to: FrameSource): Promise<FlowField> {
    return this.#engine.request('flowOf', await this.#raw(from), await this.#raw(to));
  }

  /** Ends the engine; what it still works on is rejected. */
  close() {
    this.#engine.close();
  }

  #raw(image: FrameSource) {
    return toRawFrame(image, this.#loadDecoder);
  }
}

/**
 * Opens an engine for boundaries, superpixels, discontinuities and flow of many single images: all that starting costs is
 * paid once.
 */
export function createImageEngine(options?: ImageEngineOptions): Promise<ImageEngine> {
  return opened(options, ['flow', 'contour', 'superpixel', 'still']);
}

async function opened(options: ImageEngineOptions | undefined, groups: string[]) {
  const split = splitOptions(checked(options, [...groups, ...ALWAYS]));
  const engine = await openEngine({ ...split, threads: 1 });
  return new ImageEngine(engine, decoderLoader(split.decoder));
}

/** The boundary probability of a single image, at its own size. */
export function boundaries(image: FrameSource, options?: ImageOptions): Promise<BoundaryMap> {
  return askOnce(options, ['contour', 'superpixel'], (engine) => engine.boundaries(image));
}

/** The Gabriel superpixels of a single image, at its own size. */
export async function superpixels(image: FrameSource, options?: SuperpixelOptions): Promise<Superpixels> {
  const { count, ...others } = isPlainObject(options) ? options : { count: undefined };
  const rest = isPlainObject(options) ? others : options;
  return askOnce(rest, ['contour', 'superpixel'], (engine) => engine.superpixels(image, { count }));
}

/**
 * Boundaries of a single image by the discontinuities of its pixel embedding, at its own size or reduced to
 * `still.maxSide`.
 */
export function imageDiscontinuities(
  image: FrameSource,
  options?: DiscontinuityOptions,
): Promise<ImageDiscontinuities> {
  return askOnce(options, ['still'], (engine) => engine.imageDiscontinuities(image));
}

/** The optical flow from one image to another of the same size, at that size: where each pixel goes. */
export function flow(from: FrameSource, to: FrameSource, options?: FlowOptions): Promise<FlowField> {
  return askOnce(options, ['flow'], (engine) => engine.flow(from, to));
}

/** Asks an engine one thing. */
async function askOnce<T>(
  options: ImageEngineOptions | undefined,
  groups: string[],
  question: (engine: ImageEngine) => Promise<T>,
): Promise<T> {
  const engine = await opened(options, groups);
  try {
    return await question(engine);
  } finally {
    engine.close();
  }
}

function checked(options: ImageEngineOptions | undefined, legal: string[]) {
  const stray = isPlainObject(options) && Object.keys(options).find((key) => !legal.includes(key));
  if (stray) throw illegal('param', stray, options[stray], legal.join(', '));
  return options;
}

const unscaled = <T extends { width: number; height: number }>(map: T) => onGrid(map, map.width, map.height);

/** The map with its grid's scale against an input of `width` × `height` pixels. */
export function onGrid<T extends { width: number; height: number }>(map: T, width: number, height: number): T & Grid {
  return { ...map, scaleX: width / map.width, scaleY: height / map.height };
}
