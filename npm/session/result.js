// What a run has found: `Result`.

import { TraceCutError, wholeNumber } from '../check/errors.js';
import { onGrid } from '../stages/image.js';
import { objectList, tracksDat } from './report.js';
import { REQUESTS } from './requests.js';
import { checkRuns, decodeRuns, encodeRuns } from './runs.js';
import { opened, saved } from './saved.js';

/**
 * Point trajectories. The points of trajectory `i` are `offset[i]` to `offset[i + 1]` of `x` and `y`, in input pixels,
 * one for each of the consecutive frames from `startFrame[i]` on. `id[i]` is its number in the clip, which it keeps
 * from window to window.
 * @typedef {{readonly count: number, readonly startFrame: Uint32Array, readonly offset: Uint32Array, readonly x:
 *   Float32Array, readonly y: Float32Array, readonly id:
 *   Uint32Array}} TrajectoryList
 */

/**
 * A label for each trajectory, `0` to `count - 1`; 0 is the cluster with most points.
 * @typedef {{readonly count: number, readonly label: Uint32Array}} ClusterList
 */

/**
 * The spectral embedding: `dimensions` eigenvalues, largest first, and one row of as many numbers per trajectory.
 * @typedef {{readonly dimensions: number, readonly eigenvalues: Float64Array, readonly vectors: Float32Array,
 *   readonly converged: boolean, readonly residual:
 *   number}} EmbeddingTable
 */

/**
 * Neighbour pairs with their discontinuities, and which of them are Delaunay edges of which frame.
 * @typedef {{readonly i: Uint32Array, readonly j: Uint32Array, readonly d: Float32Array, readonly frameOffset:
 *   Uint32Array, readonly frameEdges: Uint32Array}}
 *   EdgeTable
 */

/**
 * Edges between trajectories `i` and `j`, with discontinuity `d` in 0 to 1.
 * @typedef {{readonly i: Uint32Array, readonly j: Uint32Array, readonly d: Float32Array}} Edges
 */

/**
 * The object of each cluster: the label that it has in the masks, 0 for the background; null without masks. Several
 * clusters may be one object, or the background.
 * @typedef {{readonly object: Uint8Array | null}} ClusterObjects
 */

/**
 * How much each trajectory stands out against what surrounds it, 0 to 1: `ofPoints`, the greatest saliency of the
 * pixels that it went over (the paper's s), and `inContext`, the mean of that over the trajectories that move like it
 * (s̄). `foreground` is 1 where s̄ is above `saliency.threshold`, else 0.
 * @typedef {{readonly ofPoints: Float32Array, readonly inContext: Float32Array, readonly foreground: Uint8Array}}
 *   SaliencyTable
 */

/**
 * The connected pieces of the foreground: their number in each frame, and the piece of each trajectory point in its
 * frame (points as in `trajectories.x`), `0` to `count[t] - 1`. It is -1 for points that are in none: background, and
 * foreground too small to count.
 * @typedef {{readonly count: Uint32Array, readonly ofPoint: Int32Array}} ComponentTable
 */

/**
 * The scene of a frame without the objects, as RGBA bytes for `ImageData`: pixels of the background are the frame's own,
 * those behind objects come from the nearest frames that show them, as the camera moves. Alpha is 0 where none does,
 * else 255.
 * @typedef {import('../stages/image.js').Grid & {readonly data: Uint8ClampedArray<ArrayBuffer>}} Background
 */

/**
 * How likely the label of each pixel of a frame is right, in that the pixel is on an object or is not, 0 to 1, row by
 * row.
 * @typedef {import('../stages/image.js').Grid & {readonly confidence: Float32Array<ArrayBuffer>}} ConfidenceMap
 */

/**
 * How much each pixel of a frame stands out against its surroundings, 0 to 1, row by row.
 * @typedef {import('../stages/image.js').Grid & {readonly saliency: Float32Array<ArrayBuffer>}} SaliencyMap
 */

/**
 * What a cluster would cost the superpixel, all else as it is: by its trajectories, by colours where no trajectory has a
 * say, by evidence from background and looks, by links to neighbours of other clusters, and where a stroke forbids it.
 * `total` is the sum. `label` is the cluster's label in the masks, `votes` the number of its trajectories here.
 * @typedef {{readonly cluster: number, readonly label: number, readonly votes: number, readonly trajectories: number,
 *   readonly colours: number, readonly evidence: number, readonly links: number, readonly forbidden: number,
 *   readonly total: number}} LabelCost
 */

/**
 * A superpixel that shares a border (same `t`) or is of the frame before or after, with `tracks` trajectories in common;
 * `cost` is what it costs to have another cluster than that one.
 * @typedef {{readonly t: number, readonly superpixel: number, readonly cluster: number, readonly tracks: number,
 *   readonly cost: number}} SuperpixelLink
 */

/**
 * A trajectory in a superpixel, where it is in input pixels, and its cluster, -1 where that is not known. Strangers,
 * which move like nothing around them, count for all objects.
 * @typedef {{readonly x: number, readonly y: number, readonly cluster: number, readonly stranger: boolean}} Voter
 */

/**
 * Why a pixel has its label. Costs are in units of the energy, in whole steps of 1/65536, so that their sums are exact:
 * the difference of two totals is that of the energies which the cut compared.
 * @typedef {object} Explanation
 * @property {number} label in the masks
 * @property {'superpixel' | 'border' | 'stroke'} source what gave the pixel its label: its superpixel, the step after
 *   the cut that moves borders, or a stroke. The costs are those of the superpixel in any case
 * @property {number} superpixel its number in the frame
 * @property {number} cluster that the cut gave the superpixel
 * @property {number} weight λ: how much the superpixel's trajectories count, 0 where none has a say
 * @property {{readonly background: number, readonly looks: number}} evidence for an object here, negative against one:
 *   by the background, and by what objects and the ground near them look like
 * @property {readonly LabelCost[]} costs of each cluster
 * @property {readonly SuperpixelLink[]} links what binds the superpixel to others
 * @property {readonly Voter[]} voters the trajectories in it
 * @property {number} nearest the trajectory of the result nearest to the pixel, -1 where there is none
 * @property {readonly {readonly to: number, readonly affinity: number}[]} affinities its 8 greatest affinities, and to
 *   which trajectories
 * @property {{readonly cluster: number, readonly margin: number, readonly votes: number} | null} flip the cheapest
 *   cluster of another label, what it costs more, and how many more trajectories of it here would make it as cheap
 *   (Infinity where no number would); null where there is no other label
 * @property {{readonly edges: number, readonly mean: number, readonly i: number, readonly j: number, readonly d:
 *   number} | null} border the edges of the frame that join trajectories of both labels, their mean discontinuity, and
 *   the edge with the greatest; null without any
 */

/** What a run found. */
export class Result {
  #ask;

  /**
   * @param {import('./engine.js').RawResult} raw
   * @param {import('./requests.js').Ask} ask
   */
  constructor(raw, ask) {
    /** Width of the input in pixels. @readonly */
    this.width = raw.info.width;
    /** Height of the input in pixels. @readonly */
    this.height = raw.info.height;
    /** Number of frames. @readonly */
    this.numFrames = raw.info.numFrames;
    /** Point trajectories in input pixels. @readonly */
    this.trajectories = raw.trajectories;
    /** The cluster of each trajectory, and the object of each cluster. @readonly */
    this.clusters = raw.clusters;
    /**
     * The simpler segmentation by thresholded discontinuities alone (`discontinuity.threshold`); strays are clusters.
     * @readonly
     */
    this.thresholdClusters = raw.thresholdClusters;
    /** The embedding coordinates of each trajectory. @readonly */
    this.embedding = raw.embedding;
    /** Seconds spent in each stage. @readonly */
    this.seconds = raw.seconds;
    /** The objects of the masks; null without masks (`clip.dense` off, or no frames). @readonly */
    this.objects = raw.areas && objectList(raw.areas);
    /**
     * How salient each trajectory is, and which are foreground; null for trajectories without frames, which have no
     * flow.
     * @readonly
     */
    this.saliency = raw.saliency;
    /** The connected pieces of the foreground in each frame; null for trajectories without frames. @readonly */
    this.components = raw.components;
    /** The masks of all frames, one after the other; null where there are none. `labels(t)` copies one. @readonly */
    this.masks = raw.labels;
    /** The Delaunay edges of all frames; `edges(t)` gives those of one. @readonly */
    this.edgeTable = raw.edges;
    this.#ask = ask;
  }

  /**
   * The mask of frame `t`, a copy: one byte for each input pixel, row by row; 0 is the background,
   * other numbers are the labels of `objects`.
   * @param {number} t
   * @returns {Uint8Array<ArrayBuffer>}
   */
  labels(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    if (!this.masks) throw without('masks', 'masks');
    const size = this.width * this.height;
    return this.masks.slice(t * size, (t + 1) * size);
  }

  /**
   * The Gabriel superpixels of frame `t`, at the size that frames are processed at. They are fetched from the session,
   * which must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<import('../stages/image.js').Superpixels>}
   */
  async superpixels(t) {
    return this.#map('superpixels', t);
  }

  /**
   * The scene of frame `t` without the objects, at the size that frames are processed at. The session makes it at each
   * call, by its masks of that time; it must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<Background>}
   */
  async background(t) {
    return this.#map('background', t);
  }

  /**
   * The boundary probability of frame `t`, at the size that frames are processed at. The session computes it at each
   * call; it must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<import('../stages/image.js').BoundaryMap>}
   */
  async boundaries(t) {
    return this.#map('boundaries', t);
  }

  /**
   * How salient each pixel of frame `t` is, at the size that frames are processed at; the last frame is seen through
   * the flow that leads to it. The session computes it at each call; it must still be open and hold the same clip.
   * @param {number} t
   * @returns {Promise<SaliencyMap>}
   */
  async saliencyMap(t) {
    return this.#map('saliencyMap', t);
  }

  /**
   * How sure the labels of frame `t` are, at the size that frames are processed at (docs/confidence.md says how true
   * that is). The session must still be open, and neither cleared nor corrected since.
   * @param {number} t
   * @returns {Promise<ConfidenceMap>}
   */
  async confidence(t) {
    return this.#map('confidence', t);
  }

  /**
   * The mean of `confidence` over the pixels of each label in all frames: that of the background, then that of each
   * object by its label, 0 of a label without pixels.
   * @returns {Promise<Float32Array<ArrayBuffer>>}
   */
  async objectConfidence() {
    return this.#asked('objectConfidence');
  }

  /**
   * Why the pixel `x`, `y` of frame `t`, counted from 0 in input pixels, has its label: what speaks for it, what
   * against, and what would change it. Computed at each call; the session must still be open, and neither cleared nor
   * corrected since.
   * @param {number} t
   * @param {number} x
   * @param {number} y
   * @returns {Promise<Explanation>}
   */
  async explain(t, x, y) {
    wholeNumber('param', 'x', x, 0, this.width - 1);
    wholeNumber('param', 'y', y, 0, this.height - 1);
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    return this.#asked('explain', t, x, y);
  }

  /**
   * @template {import('./requests.js').MapName} N
   * @param {N} name
   * @param {import('./requests.js').Arguments<N>} place the frame
   * @returns {Promise<import('./requests.js').Answer<N> & import('../stages/image.js').Grid>}
   */
  async #map(name, ...place) {
    wholeNumber('param', 't', place[0], 0, this.numFrames - 1);
    return onGrid(await this.#asked(name, ...place), this.width, this.height);
  }

  /** @type {import('./requests.js').Ask} */
  async #asked(name, ...args) {
    const { called, from } = REQUESTS[name];
    const there = { frames: true, saliency: this.saliency, masks: this.masks };
    if (!there[from]) throw without(called, from);
    return this.#ask(name, ...args);
  }

  /**
   * The Delaunay edges of frame `t` with their discontinuities.
   * @param {number} t
   * @returns {Edges}
   */
  edges(t) {
    wholeNumber('param', 't', t, 0, this.numFrames - 1);
    const { i, j, d, frameOffset, frameEdges } = this.edgeTable;
    const chosen = frameEdges.subarray(frameOffset[t], frameOffset[t + 1]);
    return {
      i: Uint32Array.from(chosen, (edge) => /** @type {number} */ (i[edge])),
      j: Uint32Array.from(chosen, (edge) => /** @type {number} */ (j[edge])),
      d: Float32Array.from(chosen, (edge) => /** @type {number} */ (d[edge])),
    };
  }

  /**
   * All of it for `JSON.stringify`, compressed, each number to its last bit; `fromJSON` is the way back.
   * `structuredClone`
   * of a result gives its data too, as a plain object without methods, which `fromJSON` takes as well.
   * @returns {Record<string, unknown>}
   */
  toJSON() {
    return saved({ ...this, masks: this.masks && encodeRuns(this.masks) });
  }

  /**
   * A result that was saved. It has no session behind it: superpixels, boundaries, backgrounds and saliency maps are
   * gone.
   * @param {string | object} json what `JSON.stringify` made, or that parsed, or what `structuredClone` gave
   * @returns {Result} with code `data` where it is damaged, or another kind of result
   */
  static fromJSON(json) {
    return restored(json, ['trajectories', 'clusters', 'edgeTable'], (raw, ask) => new Result(raw, ask));
  }

  /**
   * The trajectories as a track file of the Moseg benchmark: number of frames, number of tracks, then for each track
   * its label and length and, line by line, `x y frame`.
   * @returns {string}
   */
  toTracksDat() {
    return tracksDat({ ...this.trajectories, numFrames: this.numFrames, label: this.clusters.label });
  }
}

/**
 * @param {string} what
 * @param {string} from what it is made from, which is not there
 */
function without(what, from) {
  const dense = from === 'masks' ? ', and clip.dense = true' : '';
  const needs = `frames, not trajectories alone${dense}`;
  return new TraceCutError('state', `this result has no ${what} (they need ${needs})`);
}

/**
 * @template T
 * @param {string | object} json
 * @param {string[]} needed
 * @param {(raw: import('./engine.js').RawResult, ask: import('./requests.js').Ask, facts: any) => T} make
 * @returns {T}
 */
export function restored(json, needed, make) {
  const found = opened(json, [...needed, 'masks']);
  const { masks, edgeTable, ...facts } = found;
  const size = facts.width * facts.height * wholeNumber('data', 'numFrames', facts.numFrames, 1, 2 ** 31);
  const labels = masks instanceof Uint32Array ? decodeRuns(checkRuns('masks', masks, size)) : masks;
  if (labels && labels.length !== size)
    throw new TraceCutError('data', `the saved masks have ${labels.length} pixels (expected ${size})`);
  return make({ ...facts, info: facts, edges: edgeTable, areas: facts.objects, labels }, noSession, facts);
}

/** @type {import('./requests.js').Ask} */
async function noSession(name) {
  throw new TraceCutError('state', `a result that was saved has no ${REQUESTS[name].called}; a session keeps them`);
}
