// What a run answers about a frame beside its masks.

/** A place in clip pixels, with the object there; -1 for none. */
export type Spot = { x: number; y: number; object: number };

/** Boundary probability of each pixel, and the same on ridges alone; pixels may be larger than those of the clip. */
export type Boundaries = { width: number; height: number; pb: Float32Array; thin: Float32Array };

/**
 * Superpixels, and the edges that they come from. Pixels may be larger than those of the clip: `x` is `(x + 0.5) *
 * scaleX - 0.5` there.
 */
export interface Superpixels {
  width: number;
  height: number;
  scaleX: number;
  scaleY: number;
  count: number;
  label: Uint32Array;
  edges: { x0: Float32Array; y0: Float32Array; x1: Float32Array; y1: Float32Array; kind: Uint8Array };
}

/** The scene without objects, RGBA; pixels as for boundaries. */
export type Plate = { width: number; height: number; data: Uint8ClampedArray<ArrayBuffer> };

/** Four kinds of boundary strength of a still image's pixels, 0 to 1. */
export type ImageEdges = {
  width: number;
  height: number;
  pb: Float32Array;
  discontinuity: Float32Array;
  spectral: Float32Array;
  combined: Float32Array;
};

/** What can be asked about a frame. */
export type Answer = { boundaries: Boundaries; superpixels: Superpixels; background: Plate; imageEdges: ImageEdges };

/** What the session, or what was made of a still image, answers about a frame; null where it knows no such thing. */
export type Answers = { [What in keyof Answer]: ((frame: number) => Promise<Answer[What]>) | null };

export const NO_ANSWERS: Answers = { boundaries: null, superpixels: null, background: null, imageEdges: null };
