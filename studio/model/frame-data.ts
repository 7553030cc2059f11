// Data of a frame besides its masks, computed on demand.

/** A position in clip pixels and the object there; -1 for none. */
export type Spot = { x: number; y: number; object: number };

/** Boundary probability of each pixel, and thinned to ridges; the resolution may be lower than the clip's. */
export type Boundaries = { width: number; height: number; pb: Float32Array; thin: Float32Array };

/**
 * Superpixels and the edges of their triangulation. The resolution may be lower than the clip's: `x` is `(x + 0.5) *
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

/** The scene without objects, RGBA; the resolution may be lower than the clip's. */
export type Plate = { width: number; height: number; data: Uint8ClampedArray<ArrayBuffer> };

/** Four kinds of boundary strength of a still image, 0 to 1. */
export type ImageEdges = {
  width: number;
  height: number;
  pb: Float32Array;
  discontinuity: Float32Array;
  spectral: Float32Array;
  combined: Float32Array;
};

export type FrameData = { boundaries: Boundaries; superpixels: Superpixels; background: Plate; imageEdges: ImageEdges };

/** Functions that load the data of a frame; null if not available. */
export type FrameDataSource = { [What in keyof FrameData]: ((frame: number) => Promise<FrameData[What]>) | null };

export const NO_FRAME_DATA: FrameDataSource = {
  boundaries: null,
  superpixels: null,
  background: null,
  imageEdges: null,
};
