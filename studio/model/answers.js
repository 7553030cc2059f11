/** What a run answers about a frame beside its masks. @module */

/**
 * @typedef {{x: number, y: number, object: number}} Spot A place in clip pixels, with the object there; -1 for none.
 */

/**
 * @typedef {{width: number, height: number, pb: Float32Array, thin: Float32Array}} Boundaries Boundary probability of
 *   each pixel, and the same on ridges alone; pixels may be larger than those of the clip.
 */

/**
 * Superpixels, and the edges that they come from. Pixels may be larger than those of the clip: `x` is `(x + 0.5) *
 * scaleX - 0.5` there.
 *
 * @typedef {object} Superpixels
 * @property {number} width
 * @property {number} height
 * @property {number} scaleX
 * @property {number} scaleY
 * @property {number} count
 * @property {Uint32Array} label
 * @property {{x0: Float32Array, y0: Float32Array, x1: Float32Array, y1: Float32Array, kind: Uint8Array}} edges
 */

/**
 * @typedef {{width: number, height: number, data: Uint8ClampedArray<ArrayBuffer>}} Plate The scene without objects, RGBA;
 *   pixels as for boundaries.
 */

/**
 * @typedef {{width: number, height: number, pb: Float32Array, discontinuity: Float32Array, spectral: Float32Array,
 *   combined: Float32Array}} ImageEdges Four kinds of boundary strength of a still image's pixels, 0 to 1.
 */

/** What can be asked about a frame. @typedef {{boundaries: Boundaries, superpixels: Superpixels, background: Plate, imageEdges: ImageEdges}} Answer */

/**
 * What the session, or what was made of a still image, answers about a frame; null where it knows no such thing.
 *
 * @typedef {{[What in keyof Answer]: ((frame: number) => Promise<Answer[What]>) | null}} Answers
 */

/** @type {Answers} */
export const NO_ANSWERS = { boundaries: null, superpixels: null, background: null, imageEdges: null };
