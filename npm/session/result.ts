// What a run has found: `Result`.

import { TraceCutError, wholeNumber } from '../check/errors.js';
import { type BoundaryMap, type Grid, type Superpixels, onGrid } from '../stages/image.js';
import { objectList, tracksDat } from './report.js';
import { type Answer, type Arguments, type Ask, type MapName, REQUESTS, type ResultName } from './requests.js';
import { checkRuns, decodeRuns, encodeRuns } from './runs.js';
import { opened, saved } from './saved.js';
import type { WindowFacts } from '../video/window.js';
import type { Info, RawResult, Stage } from './engine.js';
import type { ObjectList } from './report.js';

/**
 * Point trajectories. The points of trajectory `i` are `offset[i]` to `offset[i + 1]` of `x` and `y`, in input pixels,
 * one for each of the consecutive frames from `startFrame[i]` on. `id[i]` is its number in the clip, which it keeps
 * from window to window.
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

/** Neighbour pairs with their discontinuities, and which of them are Delaunay edges of which frame. */
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
 * The object of each cluster: the label that it has in the masks, 0 for the background; null without masks. Several
 * clusters may be one object, or the background.
 */
export type ClusterObjects = { readonly object: Uint8Array | null };

/**
 * How much each trajectory stands out against what surrounds it, 0 to 1: `ofPoints`, the greatest saliency of the
 * pixels that it went over (the paper's s), and `inContext`, the mean of that over the trajectories that move like it
 * (s̄). `foreground` is 1 where s̄ is above `saliency.threshold`, else 0.
 */
export type SaliencyTable = {
  readonly ofPoints: Float32Array;
  readonly inContext: Float32Array;
  readonly foreground: Uint8Array;
};

/**
 * The connected pieces of the foreground: their number in each frame, and the piece of each trajectory point in its
 * frame (points as in `trajectories.x`), `0` to `count[t] - 1`. It is -1 for points that are in none: background, and
 * foreground too small to count.
 */
export type ComponentTable = { readonly count: Uint32Array; readonly ofPoint: Int32Array };

/**
 * The scene of a frame without the objects, as RGBA bytes for `ImageData`: pixels of the background are the frame's own,
 * those behind objects come from the nearest frames that show them, as the camera moves. Alpha is 0 where none does,
 * else 255.
 */
export type Background = Grid & { readonly data: Uint8ClampedArray<ArrayBuffer> };

/**
 * How likely the label of each pixel of a frame is right, in that the pixel is on an object or is not, 0 to 1, row by
 * row.
 */
export type ConfidenceMap = Grid & { readonly confidence: Float32Array<ArrayBuffer> };

/** How much each pixel of a frame stands out against its surroundings, 0 to 1, row by row. */
export type SaliencyMap = Grid & { readonly saliency: Float32Array<ArrayBuffer> };

/**
 * What a cluster would cost the superpixel, all else as it is: by its trajectories, by colours where no trajectory has a
 * say, by evidence from background and looks, by links to neighbours of other clusters, and where a stroke forbids it.
 * `total` is the sum. `label` is the cluster's label in the masks, `votes` the number of its trajectories here.
 */
export type LabelCost = {
  readonly cluster: number;
  readonly label: number;
  readonly votes: number;
  readonly trajectories: number;
  readonly colours: number;
  readonly evidence: number;
  readonly links: number;
  readonly forbidden: number;
  readonly total: number;
};

/**
 * A superpixel that shares a border (same `t`) or is of the frame before or after, with `tracks` trajectories in common;
 * `cost` is what it costs to have another cluster than that one.
 */
export type SuperpixelLink = {
  readonly t: number;
  readonly superpixel: number;
  readonly cluster: number;
  readonly tracks: number;
  readonly cost: number;
};

/**
 * A trajectory in a superpixel, where it is in input pixels, and its cluster, -1 where that is not known. Strangers,
 * which move like nothing around them, count for all objects.
 */
export type Voter = { readonly x: number; readonly y: number; readonly cluster: number; readonly stranger: boolean };

/**
 * Why a pixel has its label. Costs are in units of the energy, in whole steps of 1/65536, so that their sums are exact:
 * the difference of two totals is that of the energies which the cut compared.
 */
export interface Explanation {
  /** In the masks. */
  label: number;
  /**
   * What gave the pixel its label: its superpixel, the step after the cut that moves borders, or a stroke. The costs
   * are those of the superpixel in any case.
   */
  source: 'superpixel' | 'border' | 'stroke';
  /** Its number in the frame. */
  superpixel: number;
  /** That the cut gave the superpixel. */
  cluster: number;
  /** λ: how much the superpixel's trajectories count, 0 where none has a say. */
  weight: number;
  /**
   * For an object here, negative against one: by the background, and by what objects and the ground near them look
   * like.
   */
  evidence: { readonly background: number; readonly looks: number };
  /** Of each cluster. */
  costs: readonly LabelCost[];
  /** What binds the superpixel to others. */
  links: readonly SuperpixelLink[];
  /** The trajectories in it. */
  voters: readonly Voter[];
  /** The trajectory of the result nearest to the pixel, -1 where there is none. */
  nearest: number;
  /** Its 8 greatest affinities, and to which trajectories. */
  affinities: readonly { readonly to: number; readonly affinity: number }[];
  /**
   * The cheapest cluster of another label, what it costs more, and how many more trajectories of it here would make
   * it as cheap (Infinity where no number would); null where there is no other label.
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

/** What a run found. */
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
  /** The objects of the masks; null without masks (`clip.dense` off, or no frames). */
  readonly objects: ObjectList | null;
  /**
   * How salient each trajectory is, and which are foreground; null for trajectories without frames, which have no flow.
   */
  readonly saliency: SaliencyTable | null;
  /** The connected pieces of the foreground in each frame; null for trajectories without frames. */
  readonly components: ComponentTable | null;
  /** The masks of all frames, one after the other; null where there are none. `labels(t)` copies one. */
  readonly masks: Uint8Array<ArrayBuffer> | null;
  /** The Delaunay edges of all frames; `edges(t)` gives those of one. */
  readonly edgeTable: EdgeTable;

  constructor(raw: RawResult, ask: Ask) {
    this.width = raw.info.width;
    this.height = raw.info.height;
    this.numFrames = raw.info.numFrames;
    this.trajectories = raw.trajectories;
    this.clusters = raw.clusters;
    this.thresholdClusters = raw.thresholdClusters;
    this.embedding = raw.embedding;
    this.seconds = raw.seconds;
    this.objects = raw.areas && objectList(raw.areas);
    this.saliency = raw.saliency;
    this.components = raw.components;
    this.masks = raw.labels;
    this.edgeTable = raw.edges;
    this.#ask = ask;
  }

  /**
   * The mask of frame `t`, a copy: one byte for each input pixel, row by row; 0 is the background,
   * other numbers are the labels of `objects`.
   */
  labels(t: number): Uint8Array<ArrayBuffer> {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    if (!this.masks) throw without('masks', 'masks');
    const size = this.width * this.height;
    return this.masks.slice(t * size, (t + 1) * size);
  }

  /**
   * The Gabriel superpixels of frame `t`, at the size that frames are processed at. They are fetched from the session,
   * which must still be open and hold the same clip.
   */
  async superpixels(t: number): Promise<Superpixels> {
    return this.#map('superpixels', t);
  }

  /**
   * The scene of frame `t` without the objects, at the size that frames are processed at. The session makes it at each
   * call, by its masks of that time; it must still be open and hold the same clip.
   */
  async background(t: number): Promise<Background> {
    return this.#map('background', t);
  }

  /**
   * The boundary probability of frame `t`, at the size that frames are processed at. The session computes it at each
   * call; it must still be open and hold the same clip.
   */
  async boundaries(t: number): Promise<BoundaryMap> {
    return this.#map('boundaries', t);
  }

  /**
   * How salient each pixel of frame `t` is, at the size that frames are processed at; the last frame is seen through
   * the flow that leads to it. The session computes it at each call; it must still be open and hold the same clip.
   */
  async saliencyMap(t: number): Promise<SaliencyMap> {
    return this.#map('saliencyMap', t);
  }

  /**
   * How sure the labels of frame `t` are, at the size that frames are processed at (docs/confidence.md says how true
   * that is). The session must still be open, and neither cleared nor corrected since.
   */
  async confidence(t: number): Promise<ConfidenceMap> {
    return this.#map('confidence', t);
  }

  /**
   * The mean of `confidence` over the pixels of each label in all frames: that of the background, then that of each
   * object by its label, 0 of a label without pixels.
   */
  async objectConfidence(): Promise<Float32Array<ArrayBuffer>> {
    return this.#asked('objectConfidence');
  }

  /**
   * Why the pixel `x`, `y` of frame `t`, counted from 0 in input pixels, has its label: what speaks for it, what
   * against, and what would change it. Computed at each call; the session must still be open, and neither cleared nor
   * corrected since.
   */
  async explain(t: number, x: number, y: number): Promise<Explanation> {
    wholeNumber('param', 'x', x, 0, this.width - 1);
    wholeNumber('param', 'y', y, 0, this.height - 1);
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    return this.#asked('explain', t, x, y);
  }

  async #map<N extends MapName>(name: N, ...place: Arguments<N>): Promise<Answer<N> & Grid> {
    wholeNumber('param', 't', place[0], 0, this.numFrames - 1);
    return onGrid(await this.#asked(name, ...place), this.width, this.height);
  }

  async #asked<N extends ResultName>(name: N, ...args: Arguments<N>): Promise<Answer<N>> {
    const { called, from } = REQUESTS[name];
    const there = { frames: true, saliency: this.saliency, masks: this.masks };
    if (!there[from]) throw without(called, from);
    return this.#ask(name, ...args);
  }

  /** The Delaunay edges of frame `t` with their discontinuities. */
  edges(t: number): Edges {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    const { i, j, d, frameOffset, frameEdges } = this.edgeTable;
    const chosen = frameEdges.subarray(frameOffset[t], frameOffset[t + 1]);
    return {
      i: Uint32Array.from(chosen, (edge) => i[edge]!),
      j: Uint32Array.from(chosen, (edge) => j[edge]!),
      d: Float32Array.from(chosen, (edge) => d[edge]!),
    };
  }

  /**
   * All of it for `JSON.stringify`, compressed, each number to its last bit; `fromJSON` is the way back.
   * `structuredClone`
   * of a result gives its data too, as a plain object without methods, which `fromJSON` takes as well.
   */
  toJSON(): Record<string, unknown> {
    return saved({ ...this, masks: this.masks && encodeRuns(this.masks) });
  }

  /**
   * A result that was saved. It has no session behind it: superpixels, boundaries, backgrounds and saliency maps are
   * gone.
   * @param json what `JSON.stringify` made, or that parsed, or what `structuredClone` gave
   * @returns with code `data` where it is damaged, or another kind of result
   */
  static fromJSON(json: string | object): Result {
    return restored(json, ['trajectories', 'clusters', 'edgeTable'], (raw, ask) => new Result(raw, ask));
  }

  /**
   * The trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
   * its label and length and, line by line, `x y frame`.
   */
  toTracksDat(): string {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames, label: this.clusters.label });
  }
}

/** @param from what it is made from, which is not there */
function without(what: string, from: string) {
  const dense = from === 'masks' ? ', and clip.dense = true' : '';
  const needs = `frames, not trajectories alone${dense}`;
  return new TraceCutError('state', `this result has no ${what} (they need ${needs})`);
}

/** A result as it is saved. */
type SavedResult = Omit<RawResult, 'info' | 'edges' | 'areas' | 'labels'> &
  Info &
  WindowFacts & { masks: Uint32Array | RawResult['labels']; edgeTable: EdgeTable; objects: RawResult['areas'] };

export function restored<T>(
  json: string | object,
  needed: string[],
  make: (raw: RawResult, ask: Ask, facts: WindowFacts) => T,
): T {
  const found = opened<SavedResult>(json, [...needed, 'masks']);
  const { masks, edgeTable, ...facts } = found;
  const size = facts.width * facts.height * wholeNumber('data', 'numFrames', facts.numFrames, 1, 2 ** 31);
  const labels = masks instanceof Uint32Array ? decodeRuns(checkRuns('masks', masks, size)) : masks;
  if (labels && labels.length !== size)
    throw new TraceCutError('data', `the saved masks have ${labels.length} pixels (expected ${size})`);
  return make({ ...facts, info: facts, edges: edgeTable, areas: facts.objects, labels }, noSession, facts);
}

async function noSession<N extends ResultName>(name: N, ..._args: Arguments<N>): Promise<never> {
  throw new TraceCutError('state', `a result that was saved has no ${REQUESTS[name].called}; a session keeps them`);
}
