// The results of a run: `Result`.

import { TraceCutError, checkWholeNumber } from '../check/errors.js';
import { type BoundaryMap, type Grid, type Superpixels, addScale } from '../stages/image.js';
import { listObjects, tracksDat } from './report.js';
import { type Answer, type Arguments, type Ask, type MapName, REQUESTS, type ResultName } from './requests.js';
import { checkRuns, decodeRuns, encodeRuns, restoreFields, toSaved } from './serialize.js';
import type { WindowFacts } from '../video/window.js';
import type { RawResult, SessionInfo, Stage } from './engine.js';
import type { ObjectList } from './report.js';

/**
 * Point trajectories. Trajectory `i` has the points `offset[i]` to `offset[i + 1]` of `x` and `y`, in input pixels, one for
 * each of the consecutive frames from `startFrame[i]` on. `id[i]` is its number in the clip, the same in all windows.
 */
export type TrajectoryList = {
  readonly count: number;
  readonly startFrame: Uint32Array;
  readonly offset: Uint32Array;
  readonly x: Float32Array;
  readonly y: Float32Array;
  readonly id: Uint32Array;
};

/** A label for each trajectory, `0` to `count - 1`; 0 is the cluster with most points. */
export type ClusterList = { readonly count: number; readonly label: Uint32Array };

/** The spectral embedding: `dimensions` eigenvalues, largest first, and one row of as many numbers per trajectory. */
export type EmbeddingTable = {
  readonly dimensions: number;
  readonly eigenvalues: Float64Array;
  readonly vectors: Float32Array;
  readonly converged: boolean;
  readonly residual: number;
};

/** Neighbour pairs with their discontinuities, and the pairs that are Delaunay edges of each frame. */
export type EdgeTable = {
  readonly i: Uint32Array;
  readonly j: Uint32Array;
  readonly d: Float32Array;
  readonly frameOffset: Uint32Array;
  readonly frameEdges: Uint32Array;
};

/** Edges between trajectories `i` and `j`, with discontinuity `d` in 0 to 1. */
export type Edges = { readonly i: Uint32Array; readonly j: Uint32Array; readonly d: Float32Array };

/**
 * The object of each cluster: its label in the masks, 0 for the background; empty without masks. Several clusters may form
 * one object, or the background.
 */
export type ClusterObjects = { readonly object: Uint8Array };

/**
 * Saliency of each trajectory against its surroundings, 0 to 1: `ofPoints`, the greatest saliency of the pixels along it
 * (the paper's s), and `inContext`, the mean of `ofPoints` over the trajectories that move like it (s̄). `foreground` is 1
 * where s̄ exceeds `saliency.threshold`, else 0.
 */
export type SaliencyTable = {
  readonly ofPoints: Float32Array;
  readonly inContext: Float32Array;
  readonly foreground: Uint8Array;
};

/**
 * The connected components of the foreground: their number in each frame, and the component of each trajectory point in
 * its frame (points as in `trajectories.x`), `0` to `count[t] - 1`. It is -1 for points of the background, and of
 * foreground that is too small to count.
 */
export type ComponentTable = { readonly count: Uint32Array; readonly ofPoint: Int32Array };

/**
 * The scene of a frame without the objects, as RGBA bytes for `ImageData`: background pixels are the frame's own, pixels
 * behind objects come from the nearest frames that show them, following the camera. Alpha is 0 if none does, else 255.
 */
export type Background = Grid & { readonly data: Uint8ClampedArray<ArrayBuffer> };

/**
 * Agreement of the masks with the masks of nearby frames, moved along the flow, 0 to 1: low where masks change against the
 * motion. `clip` is the mean over the frames, `frames` has each frame, `objects[i]` the object of label `i + 1` in each
 * frame; NaN where there is nothing to compare. `mergeLogOdds` is NaN unless masks by the given `discretize.mergeLogOdds`
 * agreed less than by this one.
 */
export type Agreement = {
  readonly clip: number;
  readonly frames: Float32Array<ArrayBuffer>;
  readonly objects: readonly Float32Array<ArrayBuffer>[];
  readonly mergeLogOdds: number;
};

/** The frames `from <= t < to`. */
export type FrameRange = { readonly from: number; readonly to: number };

/** Saliency of each pixel of a frame against its surroundings, 0 to 1, row by row. */
export type SaliencyMap = Grid & { readonly saliency: Float32Array<ArrayBuffer> };

/**
 * Cost of a cluster for the superpixel, all else being equal: by its trajectories, by evidence from background and
 * appearance, by links to neighbours of other clusters, and where a stroke forbids it. `total` is the sum. `label` is the
 * cluster's label in the masks, `votes` the number of its trajectories here.
 */
export type LabelCost = {
  readonly cluster: number;
  readonly label: number;
  readonly votes: number;
  readonly trajectories: number;
  readonly evidence: number;
  readonly links: number;
  readonly forbidden: number;
  readonly total: number;
};

/**
 * A superpixel that shares a border (same `t`) or lies in the frame before or after, with `tracks` trajectories in common;
 * `cost` is the cost of having another cluster than that one.
 */
export type SuperpixelLink = {
  readonly t: number;
  readonly superpixel: number;
  readonly cluster: number;
  readonly tracks: number;
  readonly cost: number;
};

/** A trajectory in a superpixel: its place in input pixels, and its cluster, -1 if unknown. */
export type Voter = { readonly x: number; readonly y: number; readonly cluster: number };

/**
 * Explanation of a pixel's label. Costs are in units of the energy, in whole steps of 1/65536, so that their sums are
 * exact: the difference of two totals is the difference of the energies which the cut compared.
 */
export interface Explanation {
  /** Label in the masks. */
  label: number;
  /**
   * Origin of the label: the superpixel, the step after the cut that refines borders, or a stroke. The costs always refer
   * to the superpixel.
   */
  source: 'superpixel' | 'border' | 'stroke';
  /** Number of the superpixel in the frame. */
  superpixel: number;
  /** Cluster of the superpixel. */
  cluster: number;
  /** λ: weight of the superpixel's trajectories, 0 if none counts. */
  weight: number;
  /** Evidence for an object, or against one if negative: by the background, and by the appearance of objects and scene. */
  evidence: { readonly background: number; readonly looks: number };
  /** Costs of each cluster. */
  costs: readonly LabelCost[];
  /** Links to other superpixels. */
  links: readonly SuperpixelLink[];
  /** Trajectories in the superpixel. */
  voters: readonly Voter[];
  /** Trajectory of the result nearest to the pixel, -1 if there is none. */
  nearest: number;
  /** Its 8 greatest affinities, with the other trajectories. */
  affinities: readonly { readonly to: number; readonly affinity: number }[];
  /**
   * The cheapest cluster of another label, its additional cost, and the number of further trajectories of it that would
   * make it as cheap (Infinity if no number would); null without another label.
   */
  flip: { readonly cluster: number; readonly margin: number; readonly votes: number } | null;
  /**
   * The edges of the frame that join trajectories of both labels, their mean discontinuity, and the edge with the
   * greatest; null without any.
   */
  border: {
    readonly edges: number;
    readonly mean: number;
    readonly i: number;
    readonly j: number;
    readonly d: number;
  } | null;
}

// Of a run without frames.
const NO_SALIENCY: SaliencyTable = {
  ofPoints: new Float32Array(0),
  inContext: new Float32Array(0),
  foreground: new Uint8Array(0),
};
const NO_COMPONENTS: ComponentTable = { count: new Uint32Array(0), ofPoint: new Int32Array(0) };

/** Results of a run. Nothing in them is null: what a run without frames or masks does not have is empty. */
export class Result {
  #ask;

  /** Width of the input in pixels. */
  readonly width: number;
  /** Height of the input in pixels. */
  readonly height: number;
  /** Number of frames. */
  readonly numFrames: number;
  /** Point trajectories in input pixels. */
  readonly trajectories: TrajectoryList;
  /** The cluster of each trajectory, and the object of each cluster. */
  readonly clusters: ClusterList & ClusterObjects;
  /** The simpler segmentation by thresholded discontinuities alone (`discontinuity.threshold`); strays are clusters. */
  readonly thresholdClusters: ClusterList;
  /** The embedding coordinates of each trajectory. */
  readonly embedding: EmbeddingTable;
  /** Seconds spent in each stage. */
  readonly seconds: Partial<Record<Stage, number>>;
  /** The objects of the masks; empty without masks (`clip.dense` off, or no frames). */
  readonly objects: ObjectList;
  /** Saliency of each trajectory, and the foreground; empty for trajectories without frames, which have no flow. */
  readonly saliency: SaliencyTable;
  /** Connected components of the foreground in each frame; empty for trajectories without frames. */
  readonly components: ComponentTable;
  /**
   * The frames, `from <= t < to`, whose masks should be looked at, in their order: those that agree much less with their
   * neighbours than the median frame does, or whose objects are suddenly larger or smaller, and up to two frames before
   * and after them; empty without masks.
   */
  readonly doubts: readonly FrameRange[];
  /** Masks of all frames, one after the other; empty without masks. `labels(t)` copies one. */
  readonly masks: Uint8Array<ArrayBuffer>;
  /** Delaunay edges of all frames; `edges(t)` returns a frame's. */
  readonly edgeTable: EdgeTable;

  constructor(raw: RawResult, ask: Ask) {
    this.width = raw.info.width;
    this.height = raw.info.height;
    this.numFrames = raw.info.numFrames;
    this.trajectories = raw.trajectories;
    this.clusters = { ...raw.clusters, object: raw.clusters.object ?? new Uint8Array(0) };
    this.thresholdClusters = raw.thresholdClusters;
    this.embedding = raw.embedding;
    this.seconds = raw.seconds;
    this.objects = listObjects(raw.areas ?? []);
    this.saliency = raw.saliency ?? NO_SALIENCY;
    this.components = raw.components ?? NO_COMPONENTS;
    this.doubts = raw.doubts ?? [];
    this.masks = raw.labels ?? new Uint8Array(0);
    this.edgeTable = raw.edges;
    this.#ask = ask;
  }

  /**
   * Returns the mask of frame `t`, a copy: one byte for each input pixel, row by row; 0 is the background, other numbers
   * are the labels of `objects`.
   */
  labels(t: number): Uint8Array<ArrayBuffer> {
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
    if (this.masks.length === 0) throw createMissingError('masks', 'masks');
    const size = this.width * this.height;
    return this.masks.slice(t * size, (t + 1) * size);
  }

  /**
   * Returns the Gabriel superpixels of frame `t`, at the working size. They are requested from the session, which must
   * still be open and hold the same clip.
   */
  async superpixels(t: number): Promise<Superpixels> {
    return this.#requestMap('superpixels', t);
  }

  /**
   * Returns the scene of frame `t` without the objects, at the working size. The session computes it at each call from
   * its present masks; it must still be open and hold the same clip.
   */
  async background(t: number): Promise<Background> {
    return this.#requestMap('background', t);
  }

  /**
   * Returns the boundary probability of frame `t`, at the working size. The session computes it at each call; it must
   * still be open and hold the same clip.
   */
  async boundaries(t: number): Promise<BoundaryMap> {
    return this.#requestMap('boundaries', t);
  }

  /**
   * Returns the saliency of each pixel of frame `t`, at the working size; the last frame's is computed from the flow that
   * leads to it. The session computes it at each call; it must still be open and hold the same clip.
   */
  async saliencyMap(t: number): Promise<SaliencyMap> {
    return this.#requestMap('saliencyMap', t);
  }

  /**
   * Returns the agreement of the masks with the masks of nearby frames, in windows of the same window. The session must
   * still be open, and neither cleared nor corrected since.
   */
  async agreement(): Promise<Agreement> {
    return this.#request('agreement');
  }

  /**
   * Explains the label of pixel `x`, `y` of frame `t`, counted from 0 in input pixels: the evidence for and against it, and
   * what would change it. Computed at each call; the session must still be open, and neither cleared nor corrected since.
   */
  async explain(t: number, x: number, y: number): Promise<Explanation> {
    checkWholeNumber('param', 'x', x, 0, this.width - 1);
    checkWholeNumber('param', 'y', y, 0, this.height - 1);
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
    return this.#request('explain', t, x, y);
  }

  async #requestMap<N extends MapName>(name: N, ...place: Arguments<N>): Promise<Answer<N> & Grid> {
    checkWholeNumber('param', 't', place[0], 0, this.numFrames - 1);
    return addScale(await this.#request(name, ...place), this.width, this.height);
  }

  async #request<N extends ResultName>(name: N, ...args: Arguments<N>): Promise<Answer<N>> {
    const { noun, needs: from } = REQUESTS[name];
    const available = { frames: true, saliency: this.components.count.length > 0, masks: this.masks.length > 0 };
    if (!available[from]) throw createMissingError(noun, from);
    return this.#ask(name, ...args);
  }

  /** Returns the Delaunay edges of frame `t` with their discontinuities. */
  edges(t: number): Edges {
    checkWholeNumber('param', 't', t, 0, this.numFrames - 1);
    const { i, j, d, frameOffset, frameEdges } = this.edgeTable;
    const edgesOfFrame = frameEdges.subarray(frameOffset[t], frameOffset[t + 1]);
    return {
      i: Uint32Array.from(edgesOfFrame, (edge) => i[edge]!),
      j: Uint32Array.from(edgesOfFrame, (edge) => j[edge]!),
      d: Float32Array.from(edgesOfFrame, (edge) => d[edge]!),
    };
  }

  /**
   * Returns all data for `JSON.stringify`, compressed without loss; `fromJSON` restores them. `structuredClone` of a result
   * returns its data as a plain object without methods, which `fromJSON` accepts too.
   */
  toJSON(): Record<string, unknown> {
    return toSaved({ ...this, masks: this.masks.length > 0 ? encodeRuns(this.masks) : null });
  }

  /**
   * Restores a saved result. It has no session: superpixels, boundaries, backgrounds and saliency maps are unavailable.
   * @param json from `JSON.stringify`, or that parsed, or from `structuredClone`
   * @throws error `data` if it is damaged, or another kind of result
   */
  static fromJSON(json: string | object): Result {
    return restoreResult(json, ['trajectories', 'clusters', 'edgeTable'], (raw, ask) => new Result(raw, ask));
  }

  /**
   * Formats the trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each
   * track its label and length and, line by line, `x y frame`.
   */
  toTracksDat(): string {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames, label: this.clusters.label });
  }
}

/** @param source the missing data that it is computed from */
function createMissingError(name: string, source: string) {
  const dense = source === 'masks' ? ', and clip.dense = true' : '';
  const needs = `frames, not trajectories alone${dense}`;
  return new TraceCutError('state', `this result has no ${name} (they need ${needs})`);
}

/** A saved result. */
type SavedResult = Omit<RawResult, 'info' | 'edges' | 'areas' | 'labels'> &
  SessionInfo &
  WindowFacts & { masks: Uint32Array | RawResult['labels']; edgeTable: EdgeTable; objects: RawResult['areas'] };

export function restoreResult<T>(
  json: string | object,
  needed: string[],
  create: (raw: RawResult, ask: Ask, facts: WindowFacts) => T,
): T {
  const saved = restoreFields<SavedResult>(json, [...needed, 'masks']);
  const { masks, edgeTable, ...facts } = saved;
  const size = facts.width * facts.height * checkWholeNumber('data', 'numFrames', facts.numFrames, 1, 2 ** 31);
  const labels = masks instanceof Uint32Array ? decodeRuns(checkRuns('masks', masks, size)) : masks;
  if (labels?.length && labels.length !== size)
    throw new TraceCutError('data', `the saved masks have ${labels.length} pixels (expected ${size})`);
  return create({ ...facts, info: facts, edges: edgeTable, areas: facts.objects, labels }, rejectRequest, facts);
}

async function rejectRequest<N extends ResultName>(name: N, ..._args: Arguments<N>): Promise<never> {
  throw new TraceCutError('state', `a result that was saved has no ${REQUESTS[name].noun}; a session keeps them`);
}
